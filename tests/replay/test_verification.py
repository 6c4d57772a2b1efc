"""`verify` names the first step that differs, and tells an edited file from an edited match."""

import copy

import pytest

import catch_arena
from catch_arena import Replay
from catch_arena.errors import ReplayError
from catch_arena.replay.comparison import verify


def altered(replay: Replay, change) -> Replay:
    twin = copy.deepcopy(replay)
    change(twin)
    return twin


def alter_action(replay: Replay) -> None:
    replay.commands[22][1] = -replay.commands[22][1]


def test_a_match_that_plays_as_recorded_has_no_faults(mixed):
    calls = []

    assert verify(mixed, lambda done, total: calls.append((done, total))) == []
    assert calls == [(step, 80) for step in range(81)]


@pytest.mark.parametrize(
    ("change", "first"),
    [
        (alter_action, "step 23"),
        (lambda match: setattr(match, "seed", 7), "the initial state"),
        (lambda match: match.withdrawals.clear(), "step 40"),
        (lambda match: setattr(match, "config", match.config.replace(initial_targets=9)), "the initial state"),
        (lambda match: setattr(match, "config", match.config.replace(control_period_ms=116)), "step 1"),
    ],
)
def test_the_first_step_of_an_edited_match_is_named(mixed, change, first):
    """An action, the seed, withdrawals, settings."""
    assert verify(altered(mixed, change)) == [f"the states first differ in {first}"]


def test_dropouts_follow_from_the_seed(fleeing):
    """With a rate of zero the match differs from the first dropout on."""
    assert fleeing.withdrawals == []
    first = next(world for world in fleeing.worlds() if any(hunter.withdrawn for hunter in world.hunters))
    found = verify(altered(fleeing, lambda match: setattr(match, "config", match.config.replace(dropout_rate=0.0))))
    assert found == [f"the states first differ in step {first.step}"]


def test_steps_after_the_end_of_the_match_are_a_fault(mixed):
    """They change nothing, so that all digests agree."""
    longer = mixed.copy()
    for numbers in (longer.choices, longer.commands, longer.digests):
        numbers.append(numbers[-1])
    assert verify(longer) == [f"the match ends in step {mixed.steps}, but {mixed.steps + 1} steps are recorded"]


def test_an_edited_digest_is_told_from_an_edited_action(mixed):
    """The steps after it agree."""
    found = verify(altered(mixed, lambda match: match.digests.__setitem__(12, b"12345678")))
    assert found == ["the states first differ in step 12; from step 13 on they agree"]


def test_worlds_stop_at_the_first_step_that_differs(mixed):
    with pytest.raises(ReplayError, match=r"does not play as it was recorded: the states first differ in step 23$"):
        list(altered(mixed, alter_action).worlds())


def test_verify_gives_each_file_its_lines_and_fails_if_any_does(mixed, tmp_path, catch_arena):
    """Sound, altered, cut and missing files together."""
    mixed.save("good.replay")
    altered(mixed, alter_action).save("played.replay")
    (tmp_path / "cut.replay").write_bytes((tmp_path / "good.replay").read_bytes()[:-1])
    result = catch_arena("verify", "played.replay", "cut.replay", "good.replay", "none.replay")

    assert result.exit_code == 2
    assert result.stdout == "good.replay: all 80 steps play as recorded\n"
    lines = result.stderr.splitlines()
    assert lines[0] == "played.replay: the states first differ in step 23"
    assert {line.split(":")[0] for line in lines[:-1]} == {"played.replay", "error"}
    assert [line.split(":")[1] for line in lines if line.startswith("error")] == [" cut.replay", " none.replay"]
    assert lines[-1] == "3 of 4 replays failed"


def test_an_edited_action_of_prey_whose_effect_ends_with_its_return_is_found():
    """A hunter that reaches everything asks in step 10; where the prey had driven until then matters no more."""
    env = catch_arena.parallel_env("tag", hunters=1, control="full", reach_m=100.0, max_cycles=40)
    env.record()
    env.reset(seed=2)
    while env.agents:
        rank = int(env.world().step == 9)
        env.step({"hunter_0": {"cmd_vel": (0.0, 0.0), "catch": rank}, "prey_0": (0.5, 0.25)})
    match = env.replay()
    found = verify(altered(match, lambda match: match.commands[4].__setitem__(1, (1.0, 0.25))))

    assert verify(match) == []
    assert found == ["the states first differ in step 5; from step 10 on they agree"]
