"""What the shipped agents decide, on views made by hand."""

import runpy
from collections import Counter
from collections.abc import Sequence
from importlib import import_module
from typing import Any

import pytest

from catch_arena import parallel_env, scenario
from catch_arena.agents import intercept
from catch_arena.config import ArenaConfig, Control
from catch_arena.policy import Limits, Policy, View
from catch_arena.tournament.entrants import enter, shipped
from catch_arena.tournament.match import play


def view(
    targets: Sequence[tuple[float, float]] = (),
    rivals: Sequence[tuple[float, float]] = (),
    *,
    ages: Sequence[float] | None = None,
    control: Control = "target",
    rival_speed: float = 1.0,
) -> View:
    """What a hunter in the middle of the arena, heading along +x, sees: (forward, left) of each, nearest first."""
    config = ArenaConfig(control=control)
    middle = config.side_m / 2
    numbers = [middle, middle, 1.0, 0.0, 0.0, 0.0, 30.0, 0.0, 0.0, 0.0]
    for rank in range(config.targets_seen):
        if rank < len(targets):
            numbers += [*targets[rank], 1.0, 1.0 if ages is None else ages[rank], 0.0]
        else:
            numbers += [0.0] * 5
    for rank in range(config.hunters_seen):
        # every rival heads the same way as the hunter itself
        numbers += [*rivals[rank], 1.0, 1.0, 0.0, rival_speed, 0.0] if rank < len(rivals) else [0.0] * 7
    mask = [1] + [int(rank < len(targets)) for rank in range(config.targets_seen)]
    return View(numbers, () if control == "velocity" else mask, Limits.of(config))


def agent(name: str, seed: int = 5) -> Any:
    made = import_module(f"catch_arena.agents.{name}").Agent()
    made.reset(seed)
    return made


def test_the_shipped_agents_are_these():
    hunters = ["contested", "contested_by_time", "first", "idle", "intercept", "nearest", "patrol", "random"]
    assert list(shipped()) == sorted([*hunters, "corners", "flee", "search"])
    assert all(line.endswith(".") for line in shipped().values())


@pytest.mark.parametrize("name", list(shipped()))
def test_every_shipped_agent_is_a_policy_and_acts_legally_with_and_without_targets(name):
    made = agent(name)
    assert isinstance(made, Policy)
    control = getattr(made, "control", "target")
    env = parallel_env("standard", control=control)
    for seen in (view(control=control), view([(1.0, 0.0), (2.0, 1.0)], [(3.0, 0.0)], control=control)):
        env.reset(seed=1)
        env.check_action("hunter_0", made.act(seen))


def test_idle_holds():
    assert agent("idle").act(view([(1.0, 0.0)])) == 0


def test_first_takes_the_oldest_and_of_equally_old_ones_the_nearer():
    three = [(1.0, 0.0), (2.0, 0.0), (3.0, 0.0)]
    assert agent("first").act(view(three, ages=[1.0, 7.0, 7.0])) == 2
    assert agent("first").act(view()) == 0


def test_nearest_takes_rank_1_whoever_is_nearer_to_it():
    assert agent("nearest").act(view([(2.0, 0.0), (0.0, 3.0)], [(2.1, 0.0)])) == 1
    assert agent("nearest").act(view()) == 0


def test_contested_leaves_a_race_that_it_would_lose():
    assert agent("contested").act(view([(2.0, 0.0), (0.0, 3.0)], [(2.5, 0.0)])) == 2
    assert agent("contested").act(view([(2.0, 0.0), (0.0, 3.0)])) == 1


def test_contested_takes_the_race_that_it_loses_by_least_where_it_loses_all():
    # 0.5 m from a rival and 2 m away: 1.5 m behind; 2.9 m from it and 3 m away: 0.1 m behind
    assert agent("contested").act(view([(2.0, 0.0), (0.0, 3.0)], [(2.5, 0.0), (0.0, 5.9)])) == 2


def test_contested_by_time_prefers_what_lies_ahead_to_what_is_a_little_nearer_behind():
    two = [(-2.0, 0.0), (2.2, 0.0)]
    assert agent("contested").act(view(two)) == 1
    assert agent("contested_by_time").act(view(two)) == 2


def test_contested_by_time_counts_a_rivals_turn_too():
    # the rival is nearer, but has to turn round: 1.8 m and half a turn against 2 m straight on
    assert agent("contested").act(view([(2.0, 0.0), (0.0, 2.5)], [(3.8, 0.0)])) == 2
    assert agent("contested_by_time").act(view([(2.0, 0.0), (0.0, 2.5)], [(3.8, 0.0)])) == 1


def test_contested_by_time_does_not_fear_a_rival_that_stands_still():
    near_it = [(2.0, 0.0), (0.0, 2.5)], [(1.5, 0.0)]
    assert agent("contested_by_time").act(view(*near_it, rival_speed=1.0)) == 2
    assert agent("contested_by_time").act(view(*near_it, rival_speed=0.0)) == 1


def test_patrol_drives_flat_out_to_what_lies_ahead():
    speed, turn = agent("patrol").act(view([(2.0, 0.0)], control="velocity"))
    assert (speed, turn) == (1.0, 0.0)


def test_patrol_turns_on_the_spot_to_what_lies_behind():
    speed, turn = agent("patrol").act(view([(-2.0, 0.5)], control="velocity"))
    assert (speed, turn) == (0.0, 1.0)


def test_patrol_slows_where_the_arc_to_a_target_is_tight():
    speed, _ = agent("patrol").act(view([(0.1, 0.4)], control="velocity"))
    assert 0.0 < speed < 1.0


def test_patrol_moves_away_from_a_rival_when_nothing_is_in_view():
    # the rival stands on the left, so the hunter's own ground lies to the right
    _, turn = agent("patrol").act(view(rivals=[(0.0, 1.0)], control="velocity"))
    assert turn < 0.0


def test_random_follows_from_its_seed_alone():
    seen = view([(1.0, 0.0), (2.0, 0.0), (3.0, 0.0)])

    def choices(seed: int) -> list[int]:
        made = agent("random", seed)
        return [made.act(seen) for _ in range(50)]

    assert choices(1) == choices(1) != choices(2)
    assert set(choices(1)) == {0, 1, 2, 3}


def test_every_agent_plays_a_whole_match_in_its_own_control():
    names = list(shipped())
    policies = [one.create() for one in enter(names)]
    played: set[tuple[str, ...]] = set()
    config = scenario("standard", hunters=len(names), time_limit_s=20)
    result = play(config, 11, policies, names, watch=lambda env: played.add(env.config.controls))
    assert played == {tuple("velocity" if name in {"intercept", "patrol", "search"} else "target" for name in names)}
    scores = dict(zip(names, result.scores, strict=True))
    assert scores["idle"] == 0
    assert scores["patrol"] > scores["random"]
    assert result.steps == 200


def test_who_leads_a_fleeing_target_beats_who_follows_it(monkeypatch):
    """The same agent, but for where it aims; seats are taken in turn."""
    leads, follows = (runpy.run_path(intercept.__file__) for _ in range(2))
    monkeypatch.setitem(follows["meeting_point"].__globals__, "LONGEST_LEAD_S", 0.0)
    config, scores = scenario("evasive", hunters=2, time_limit_s=30), Counter[str]()
    for seed in range(20):
        seated = [("leads", leads), ("follows", follows)][:: 1 if seed % 2 else -1]
        result = play(config, seed, [module["Agent"]() for _, module in seated], [name for name, _ in seated])
        scores.update({name: score for (name, _), score in zip(seated, result.scores, strict=True)})
    assert scores["leads"] > 1.1 * scores["follows"]
