"""Chapter 7, observation: every clause on every adjudicator; tests/oracle has those of partial views."""

import math
from typing import Any

import numpy as np
import pytest
from rulebook.conftest import ArenaFactory

from catch_arena.config import ArenaConfig
from catch_arena.envs.parallel import parallel_env
from catch_arena.layout import RivalFeatures, SelfFeatures, columns, groups, observation_size, state_columns
from catch_arena.policy import Limits, View

STILL = (0.0, 0.0)
OWN = len(SelfFeatures._fields)


@pytest.mark.rule("R7.1")
def test_r7_1_first_the_hunter_itself(arena: ArenaFactory) -> None:
    """Position, heading, velocities, time left and score, in the world's units."""
    match = arena(control="velocity", time_limit_s=0.25)
    match.place(hunters=[(3.0, 4.0, 0.7)])
    match.step((0.5, 0.25))
    found = match.own()
    x, y, theta, v, w = match.hunter()[:5]
    assert (v, w) == (1.0, 1.0)
    expected = (x, y, math.cos(theta), math.sin(theta), 1.0, 1.0, 0.15, 0.0, 0.0, 0.0)
    assert tuple(found.values()) == pytest.approx(expected, abs=1e-6)
    match.hold(2)
    assert match.truncated
    assert match.own()["time_left"] == 0.0


@pytest.mark.rule("R7.1")
def test_r7_1_the_integrals_are_seen(arena: ArenaFactory) -> None:
    """R4.3's two."""
    match = arena(gains={"ki_w": 1.0}, max_speed_mps=50.0, max_turn_rate_radps=50.0)
    match.place(hunters=[(3.0, 4.0, 0.0)], targets=[(5.0, 6.0)])
    match.step(1)
    assert match.own()["distance_integral"] == pytest.approx(0.1 * math.sqrt(8), abs=1e-6)
    assert match.own()["bearing_integral"] == pytest.approx(0.1 * math.pi / 4, abs=1e-6)


@pytest.mark.rule("R7.1")
def test_r7_1_targets_stand_in_the_hunters_own_frame_nearest_first(arena: ArenaFactory) -> None:
    """Forward and left, their age, and which one is active."""
    match = arena(control="full", observed_targets=4)
    match.hold()
    match.place(hunters=[(5.0, 5.0, math.pi / 2)], targets=[(5.0, 8.0), (4.0, 5.0), (7.0, 5.0)])
    match.look()
    age = (match.time - 100) / 1000
    first, second, third, fourth = match.seen_targets()
    assert tuple(first.values()) == pytest.approx((0.0, 1.0, 1.0, age, 0.0), abs=1e-7)
    assert tuple(second.values()) == pytest.approx((0.0, -2.0, 1.0, age, 0.0), abs=1e-7)
    assert tuple(third.values()) == pytest.approx((3.0, 0.0, 1.0, age, 0.0), abs=1e-7)
    assert set(fourth.values()) == {0.0}
    match.step((STILL, 2))
    assert [target["age"] for target in match.seen_targets()] == pytest.approx([age + 0.1] * 3 + [0.0])
    assert [target["active"] for target in match.seen_targets()] == [0.0, 1.0, 0.0, 0.0]


@pytest.mark.rule("R7.1")
def test_r7_1_targets_equally_near_are_ordered_by_number(arena: ArenaFactory) -> None:
    """A.7's `near`: of a metre a tenth of a micrometre more makes no difference, and a whole one less does."""
    match = arena(observed_targets=3)
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(6.0, 5.0), (5.0, 6.0000001), (4.000001, 5.0)])
    match.look()
    assert [round(target["left"]) for target in match.seen_targets()] == [0, 0, 1]
    assert [round(target["forward"]) for target in match.seen_targets()] == [-1, 1, 0]


@pytest.mark.rule("R7.1")
def test_r7_1_the_k_nearest_are_seen_eight_by_default(arena: ArenaFactory) -> None:
    """Eight of twelve are seen, or all if fewer may be alive."""
    match = arena()
    match.place(hunters=[(0.0, 0.0, 0.0)], targets=[(11.0 - 0.5 * i, 0.0) for i in range(12)])
    match.look()
    assert [target["forward"] for target in match.seen_targets()] == pytest.approx([5.5 + 0.5 * i for i in range(8)])
    assert ArenaConfig(max_targets=3, initial_targets=0).targets_seen == 3


@pytest.mark.rule("R7.1")
def test_r7_1_rivals_stand_in_the_hunters_own_frame_nearest_first(arena: ArenaFactory) -> None:
    """The columns are place, heading, velocity, and their score less one's own."""
    match = arena(hunters=3, control="full", max_targets=2, observed_targets=1)
    match.place(
        hunters=[(5.0, 5.0, math.pi / 2), (5.0, 8.0, 0.0), (7.0, 5.0, math.pi)], targets=[(5.0, 8.0), (9.0, 9.0)]
    )
    match.look()
    near, far = match.seen_rivals()
    assert tuple(near.values()) == pytest.approx((0.0, -2.0, 1.0, 0.0, 1.0, 0.0, 0.0), abs=1e-6)
    assert tuple(far.values()) == pytest.approx((3.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0), abs=1e-6)
    match.step((STILL, 0), (STILL, 1), ((0.25, 0.0), 0))
    near, far = match.seen_rivals()
    assert near["linear_velocity"] == 0.5
    assert near["score_difference"] == 0.0
    assert far["score_difference"] == 1.0
    assert [rival["score_difference"] for rival in match.seen_rivals(1)] == [-1.0, -1.0]


@pytest.mark.rule("R7.1")
@pytest.mark.parametrize("swapped", [False, True])
def test_r7_1_equally_near_rivals_are_ordered_by_what_is_seen_of_them(arena: ArenaFactory, swapped: bool) -> None:
    """The greater left, then the greater forward, then the greater cosine: never the seat."""
    match = arena(hunters=3)
    for one, other, column, greater, lesser in (
        ((5.0, 6.0, 0.0), (5.0, 4.0, 0.0), "left", 1.0, -1.0),
        ((6.0, 5.0, 0.0), (4.0, 5.0, 0.0), "forward", 1.0, -1.0),
        ((5.0, 4.0, 0.0), (5.0, 4.0, 3.0), "heading_cos", 1.0, math.cos(3.0)),
        ((5.0, 4.0, 1.0), (5.0, 4.0, -1.0), "heading_sin", math.sin(1.0), math.sin(-1.0)),
    ):
        rivals = [other, one] if swapped else [one, other]
        match.place(hunters=[(5.0, 5.0, 0.0), *rivals])
        assert [rival[column] for rival in match.seen_rivals()] == pytest.approx([greater, lesser], abs=1e-6)


@pytest.mark.rule("R7.1")
@pytest.mark.parametrize("swapped", [False, True])
def test_r7_1_rivals_that_differ_in_velocity_alone_are_ordered_by_it(arena: ArenaFactory, swapped: bool) -> None:
    """Both drive on into one corner: the faster one comes first."""
    match = arena(hunters=3, control="velocity")
    match.place(hunters=[(5.0, 5.0, 0.0), *[(0.0, 0.0, -2.0)] * 2])
    match.step((0.0, 0.0), *[(0.5, 0.0), (1.0, 0.0)][:: -1 if swapped else 1])
    assert [rival["linear_velocity"] for rival in match.seen_rivals()] == [2.0, 1.0]


@pytest.mark.rule("R7.1")
def test_r7_1_at_most_the_nearest_seven_rivals_are_seen_by_default(arena: ArenaFactory) -> None:
    """Seven of nine are seen, or all of fewer, or as many as the scenario says."""
    match = arena(hunters=10)
    match.place(hunters=[(float(seat), 5.0, 0.0) for seat in range(10)])
    assert [rival["forward"] for rival in match.seen_rivals()] == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]
    assert [rival["forward"] for rival in match.seen_rivals(9)] == [-1.0, -2.0, -3.0, -4.0, -5.0, -6.0, -7.0]
    assert ArenaConfig(hunters=3).hunters_seen == 2
    assert ArenaConfig(hunters=3, observed_hunters=1).hunters_seen == 1
    assert ArenaConfig(hunters=1).hunters_seen == 0


def read_by_name(view: View, config: ArenaConfig) -> dict[str, float]:
    """All that a view shows, under the names of the observation's columns."""
    read = {name: getattr(view, name) for name in SelfFeatures._fields}
    for target in view.targets:
        names = groups(config)[1].table._fields
        its = {name: getattr(target, name, 1.0) for name in names}  # who is in view is present
        read |= {f"target_{target.rank}.{name}": float(value) for name, value in its.items()}
    for rival in view.rivals:
        its = {name: getattr(rival, name, 1.0) for name in RivalFeatures._fields}
        read |= {f"rival_{rival.rank}.{name}": float(value) for name, value in its.items()}
    return read


@pytest.mark.rule("R7.1")
@pytest.mark.parametrize("motion", ["still", "wander"])
@pytest.mark.parametrize("control", ["target", "velocity", "full"])
def test_r7_1_one_table_gives_every_number_its_name_place_and_range(control: str, motion: str) -> None:
    """A random match stays within the table's bounds and the space's; the named view reads the same numbers."""
    env = parallel_env(
        "standard",
        hunters=3,
        control=control,
        target_motion=motion,
        reverse=True,
        time_limit_s=20.0,
        gains={"ki_w": 1.0},
    )
    config = env.config
    table = columns(config)
    low = np.array([column.low for column in table], np.float32)
    high = np.array([column.high for column in table], np.float32)
    assert len({column.name for column in table}) == len(table) == observation_size(config)
    observations, infos = env.reset(seed=4)
    for agent in env.agents:
        env.action_space(agent).seed(4)
    while env.agents:
        for seat, agent in enumerate(env.agents):
            observation = observations[agent]
            assert observation.dtype == np.float32
            assert env.observation_space(agent).contains(observation)
            assert np.all(observation >= low)
            assert np.all(observation <= high)
            world = env.world().hunters[seat]
            mask: Any = infos[agent].get("action_mask", ())
            view = View(observation, mask, Limits.of(config, seat))
            assert (view.x, view.y, view.score) == (np.float32(world.x), np.float32(world.y), world.score)
            assert len(view.targets) == min(8, len(env.world().targets))
            assert len(view.rivals) == 2
            named = dict(zip((column.name for column in table), observation.tolist(), strict=True))
            assert named == {**dict.fromkeys(named, 0.0), **read_by_name(view, config)}
        observations, _, _, _, infos = env.step({agent: env.action_space(agent).sample() for agent in env.agents})


@pytest.mark.rule("R7.2")
def test_r7_2_ranks_without_a_target_are_zero_and_masked(arena: ArenaFactory) -> None:
    """Hold is always legal."""
    match = arena(control="full", observed_targets=3)
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(5.1, 5.0), (9.0, 5.0)])
    match.look()
    assert match.mask(0) == [1, 1, 1, 0]
    assert set(match.seen_targets()[2].values()) == {0.0}
    match.step((STILL, 1))
    assert match.mask(0) == [1, 1, 0, 0]
    assert [set(target.values()) for target in match.seen_targets()[1:]] == [{0.0}] * 2
    match.step(((1.0, 0.0), 0))
    assert match.mask(0) == [1, 1, 0, 0]


@pytest.mark.rule("R7.2")
def test_r7_2_where_asked_for_the_mask_stands_in_the_observation_under_target_control() -> None:
    """Other hunters' observations stay arrays."""
    env = parallel_env("standard", hunters=2, control=("target", "velocity"), mask_in_observation=True)
    observations, infos = env.reset(seed=1)
    assert set(observations["hunter_0"]) == {"observation", "action_mask"}
    assert np.array_equal(observations["hunter_0"]["action_mask"], infos["hunter_0"]["action_mask"])
    assert observations["hunter_1"].shape == observations["hunter_0"]["observation"].shape
    for agent in env.agents:
        assert env.observation_space(agent).contains(observations[agent])


@pytest.mark.rule("R7.3")
def test_r7_3_state_is_the_global_view_in_the_world_frame() -> None:
    """Columns have the table's names and the world's numbers."""
    env = parallel_env("standard", hunters=2, initial_targets=3)
    env.reset(seed=6)
    for _ in range(7):
        env.step({"hunter_0": 1, "hunter_1": 2})
    state = env.state()
    assert state.dtype == np.float32
    assert env.state_space.contains(state)
    names = [column.name for column in state_columns(env.config)]
    assert len(names) == len(set(names)) == len(state)
    view = dict(zip(names, state.tolist(), strict=True))
    world = env.world()
    assert view["time_left"] == pytest.approx(59.3, abs=1e-5)
    for seat, hunter in enumerate(world.hunters):
        assert view[f"hunter_{seat}.x"] == np.float32(hunter.x)
        assert view[f"hunter_{seat}.y"] == np.float32(hunter.y)
        assert view[f"hunter_{seat}.heading_cos"] == pytest.approx(math.cos(hunter.theta), abs=1e-6)
        assert view[f"hunter_{seat}.heading_sin"] == pytest.approx(math.sin(hunter.theta), abs=1e-6)
        assert view[f"hunter_{seat}.score"] == hunter.score
    for place, target in enumerate(world.targets, start=1):
        assert view[f"target_{place}.present"] == 1.0
        assert (view[f"target_{place}.x"], view[f"target_{place}.y"]) == (np.float32(target.x), np.float32(target.y))
        assert view[f"target_{place}.age"] == pytest.approx((700 - target.spawned_ms) / 1000, abs=1e-6)
    assert view[f"target_{len(world.targets) + 1}.present"] == 0.0
