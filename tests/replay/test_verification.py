"""`verify` names the first step that differs, and tells an edited file from an edited match."""

import copy
import re

import pytest

import catch_arena
from catch_arena import Replay
from catch_arena.errors import ReplayError
from catch_arena.replay.verification import verify


def altered(replay: Replay, change) -> Replay:
    twin = copy.deepcopy(replay)
    change(twin)
    return twin


def alter_action(replay: Replay) -> None:
    replay.commands[22][1] = -replay.commands[22][1]


def number_of(replay: Replay, step: int, seat: int, field: int) -> int:
    """A hunter's number of a state: x is field 0, y 1, the angular velocity 4."""
    return int(replay.states[step][8 + 11 * seat + field])


def test_a_match_that_plays_as_recorded_has_no_faults(mixed):
    calls = []

    assert verify(mixed, lambda done, total: calls.append((done, total))) == []
    assert calls == [(step, 80) for step in range(81)]


def test_an_edited_action_is_named_by_what_it_moves(mixed):
    """The hunter, each number; no other hunter."""
    found = verify(altered(mixed, alter_action))

    assert found[0] == "the states first differ in step 23"
    assert all(line.startswith("step 23: hunter_1 (b): ") for line in found[1:])
    rate = number_of(mixed, 23, 1, 4) / 1e6
    assert (
        f"step 23: hunter_1 (b): angular velocity is {rate:.6f} rad/s as recorded and {-rate:.6f} rad/s as replayed"
    ) in found


@pytest.mark.parametrize(
    ("change", "first", "line"),
    [
        (lambda match: setattr(match, "seed", 7), "the initial state", r"hunter_0 \(a\): x is"),
        (lambda match: match.withdrawals.clear(), "step 40", r"hunter_2 \(c\): withdrawn is yes as recorded and no as"),
        (
            lambda match: setattr(match, "config", match.config.replace(initial_targets=9)),
            "the initial state",
            r"target_turtle_9: alive as replayed, not as recorded",
        ),
        (
            lambda match: setattr(match, "config", match.config.replace(control_period_ms=116)),
            "step 1",
            r"clock and counters: time is 100 ms as recorded and 116 ms as replayed",
        ),
    ],
)
def test_an_edited_header_is_named_by_what_it_changes(mixed, change, first, line):
    """Seed, withdrawals, settings."""
    found = verify(altered(mixed, change))

    assert found[0] == f"the states first differ in {first}"
    assert any(re.match(f"{first}: {line}", one) for one in found), found


@pytest.mark.parametrize(
    ("field", "change", "difference"),
    [
        (1, 17, r"x is \d+\.\d{6} m as recorded and \d+\.\d{6} m as replayed"),
        (3, -5, r"theta is .* rad as replayed"),
        (4, 100, r"appeared is \d+ ms as recorded and \d+ ms as replayed"),
        (5, 1, r"linear velocity is .* m/s as replayed"),
        (6, 1, r"angular velocity is .* rad/s as replayed"),
        (7, 1, r"at wall is yes as recorded and no as replayed"),
    ],
)
def test_an_edited_number_of_a_moving_target_is_named_from_the_file_too(fleeing, tmp_path, field, change, difference):
    """Each of its numbers; the edit is written and read again."""

    def shift(match):
        match.states[50][8 + 4 * 11 + field] += change

    altered(fleeing, shift).save(tmp_path / "edited.replay")
    number = fleeing.states[50][8 + 4 * 11]
    first, line = verify(Replay.load(tmp_path / "edited.replay"))
    assert first == "the states first differ in step 50, although their digests agree; from step 51 on they agree"
    assert re.fullmatch(rf"step 50: target_turtle_{number}: {difference}", line)


def test_dropouts_follow_from_the_seed(fleeing):
    """With a rate of zero the match differs from the first dropout on."""
    assert fleeing.withdrawals == []
    first = next(world for world in fleeing.worlds() if any(hunter.withdrawn for hunter in world.hunters))
    found = verify(altered(fleeing, lambda match: setattr(match, "config", match.config.replace(dropout_rate=0.0))))

    assert found[0] == f"the states first differ in step {first.step}"
    for seat, hunter in enumerate(first.hunters):
        line = f"step {first.step}: hunter_{seat} ({'abcd'[seat]}): withdrawn is yes as recorded and no as replayed"
        assert (line in found) == hunter.withdrawn


def test_steps_after_the_end_of_the_match_are_a_fault(mixed):
    """They change nothing, so that all digests agree."""
    longer = mixed.copy()
    for numbers in (longer.choices, longer.commands, longer.prey_commands, longer.digests, longer.states):
        numbers.append(numbers[-1])
    assert verify(longer) == [f"the match ends in step {mixed.steps}, but {mixed.steps + 1} steps are recorded"]


def test_an_edited_digest_is_told_from_an_edited_action(mixed):
    """The steps after it agree."""
    found = verify(altered(mixed, lambda match: match.digests.__setitem__(12, b"12345678")))
    assert found == [
        "the states first differ in step 12; from step 13 on they agree",
        "step 12: every number differs by less than a millionth of its unit",
    ]


def test_worlds_stop_at_the_first_step_that_differs(mixed):
    with pytest.raises(
        ReplayError, match="the states first differ after 23 steps; catch-arena verify shows the numbers"
    ):
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


def test_an_edited_action_of_prey_is_named_by_the_target_that_it_moves(hunted):
    found = verify(altered(hunted, lambda match: match.prey_commands[0].__setitem__(0, (0.1, 0.9))))

    assert found[0] == "the states first differ in step 1"
    assert all(line.startswith("step 1: target_turtle_1: ") for line in found[1:])
    assert any("linear velocity is " in line and "as recorded and 0.100000 m/s as replayed" in line for line in found)


def test_an_edited_action_of_prey_whose_effect_ends_with_its_return_is_found():
    """A hunter that reaches everything asks in step 10; where the prey had driven until then matters no more."""
    env = catch_arena.parallel_env("tag", hunters=1, control="full", reach_m=100.0, max_cycles=40)
    env.record()
    env.reset(seed=2)
    while env.agents:
        rank = int(env.world().step == 9)
        env.step({"hunter_0": {"cmd_vel": (0.0, 0.0), "catch": rank}, "prey_0": (0.5, 0.25)})
    match = env.replay()
    found = verify(altered(match, lambda match: match.prey_commands[4].__setitem__(0, (1.0, 0.25))))

    assert verify(match) == []
    assert found[0] == "the states first differ in step 5; from step 10 on they agree"
    assert any(line.startswith("step 5: target_turtle_1: x is ") for line in found)


def test_altered_numbers_of_prey_are_told_by_its_name(hunted):
    for place, line in (
        (-9, r"prey_0 \(p\): target is target_turtle_\d+ as recorded and target_turtle_1 as replayed"),
        (-5, r"prey_1 \(q\): times caught is 7 as recorded and 0 as replayed"),
        (-1, r"prey_2 \(p\): caught at is 7 ms as recorded and -1 ms as replayed"),
    ):
        _, found = verify(altered(hunted, lambda match, place=place: match.states[1].__setitem__(place, 7)))
        assert re.fullmatch(rf"step 1: {line}", found), found
