"""Shipped agents decide as docs/reference/agents.md says, on views made by hand, and always legally."""

import math
import runpy
from collections import Counter
from collections.abc import Sequence
from importlib import import_module
from itertools import permutations
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from catch_arena import parallel_env, scenario
from catch_arena.agents import intercept
from catch_arena.agents.assignment import cheapest_assignment
from catch_arena.agents.pure_pursuit import follow
from catch_arena.agents.spoiler import leading_rival
from catch_arena.agents.tour import PATIENCE_S, best_tour, leg_s
from catch_arena.config import ArenaConfig, Control
from catch_arena.policy import Limits, Policy, View
from catch_arena.tournament.loading import shipped
from catch_arena.tournament.match_loop import play_match

DRIVING = [
    name
    for name in shipped()
    if getattr(import_module(f"catch_arena.agents.{name}").Agent, "control", "target") == "velocity"
]
"""Those under velocity control."""


def view(
    targets: Sequence[tuple[float, float]] = (),
    rivals: Sequence[tuple[float, float]] = (),
    *,
    ages: Sequence[float] | None = None,
    control: Control = "target",
    rival_speed: float = 1.0,
    differences: Sequence[float] = (0.0,) * 3,
) -> View:
    """Return the view of a hunter in the middle that heads along +x: (forward, left) of each, nearest first."""
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
        its = [1.0, 1.0, 0.0, rival_speed, differences[rank]]
        numbers += [*rivals[rank], *its] if rank < len(rivals) else [0.0] * 7
    mask = [1] + [int(rank < len(targets)) for rank in range(config.targets_seen)]
    return View(numbers, () if control == "velocity" else mask, Limits.of(config))


def agent(name: str, seed: int = 5) -> Any:
    made = import_module(f"catch_arena.agents.{name}").Agent()
    made.reset(seed)
    return made


AHEAD, ASIDE = (2.0, 0.0), (0.0, 3.0)
NEAR_IT = (1.5, 0.0)


@pytest.mark.parametrize(
    ("name", "seen", "rank"),
    [
        ("idle", view([(1.0, 0.0)]), 0),
        ("first", view([(1.0, 0.0), (2.0, 0.0), (3.0, 0.0)], ages=[1.0, 7.0, 7.0]), 2),
        ("first", view(), 0),
        ("nearest", view([AHEAD, ASIDE], [(2.1, 0.0)]), 1),
        ("contested", view([AHEAD, ASIDE], [(2.5, 0.0)]), 2),
        ("contested", view([AHEAD, ASIDE]), 1),
        # 0.5 m from a rival and 2 m away: 1.5 m behind; 2.9 m from it and 3 m away: 0.1 m behind
        ("contested", view([AHEAD, ASIDE], [(2.5, 0.0), (0.0, 5.9)]), 2),
        ("contested_by_time", view([(-2.0, 0.0), (2.2, 0.0)]), 2),
        # the rival is nearer, but has to turn round: 1.8 m and half a turn against 2 m straight on
        ("contested_by_time", view([AHEAD, (0.0, 2.5)], [(3.8, 0.0)]), 1),
        ("contested_by_time", view([AHEAD, (0.0, 2.5)], [NEAR_IT], rival_speed=1.0), 2),
        ("contested_by_time", view([AHEAD, (0.0, 2.5)], [NEAR_IT], rival_speed=0.0), 1),
    ],
)
def test_an_agent_that_chooses_takes_the_target_that_its_page_says(name, seen, rank):
    assert agent(name).act(seen) == rank


@pytest.mark.parametrize("name", list(shipped()))
def test_every_shipped_agent_is_a_policy_and_acts_legally_with_and_without_targets(name):
    made = agent(name)
    assert isinstance(made, Policy)
    control = getattr(made, "control", "target")
    env = parallel_env("standard", control=control)
    for seen in (view(control=control), view([(1.0, 0.0), (2.0, 1.0)], [(3.0, 0.0)], control=control)):
        env.reset(seed=1)
        env.check_action("hunter_0", made.act(seen))


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


def turn_of(name: str, seen: View) -> float:
    """To which side an agent turns."""
    return float(agent(name).act(seen)[1])


PLANNING = ("assignment", "pid", "pure_pursuit", "spoiler", "tour", "triage", "voronoi")
"""Those that neither chase what is caught already nor run races that are lost by far."""


@pytest.mark.parametrize("name", PLANNING)
def test_what_is_in_reach_and_nobody_is_nearer_to_is_as_good_as_caught(name):
    caught_and_left, caught_and_right = [(0.2, 0.0), (0.0, 2.0)], [(0.2, 0.0), (0.0, -2.0)]
    assert (
        turn_of(name, view(caught_and_left, control="velocity"))
        > 0.0
        > turn_of(name, view(caught_and_right, control="velocity"))
    )
    # patrol drives on at it, and so do these where a rival is nearer to it
    assert turn_of("patrol", view(caught_and_left, control="velocity")) == 0.0
    assert abs(turn_of(name, view([(0.2, 0.0)], [(0.25, 0.0)], control="velocity"))) < 1e-9


@pytest.mark.parametrize("name", PLANNING)
def test_a_race_that_is_lost_by_far_is_not_run(name):
    # the rival and its target lie to the left, so the hunter's own ground lies to the right
    lost = view([(0.0, 3.0)], [(-1.0, 3.0)], control="velocity")
    assert turn_of("patrol", lost) > 0.0 > turn_of(name, lost)


def test_assignment_leaves_the_nearest_target_to_a_rival_that_has_no_other():
    # both are nearest to the target ahead; the rival (0.1 m farther away) has nothing else in half the arena
    shared, own = (1.5, 0.0), (1.6, 1.0)
    seen = view([shared, own], [(-0.1, -0.2)], control="velocity")
    assert turn_of("triage", seen) == 0.0 < turn_of("assignment", seen)


costs = st.integers(1, 5).flatmap(
    lambda columns: st.lists(
        st.lists(st.one_of(st.integers(-3, 3), st.floats(-10, 10)), min_size=columns, max_size=columns),
        min_size=1,
        max_size=5,
    )
)


@given(costs)
def test_the_assignment_is_the_cheapest_of_all_permutations(costs):
    """Tried one by one; with more rows than columns some rows are left out."""
    rows, columns = len(costs), len(costs[0])
    if rows <= columns:
        tries = [list(zip(range(rows), chosen, strict=True)) for chosen in permutations(range(columns), rows)]
    else:
        tries = [list(zip(chosen, range(columns), strict=True)) for chosen in permutations(range(rows), columns)]
    assigned = [(row, column) for row, column in enumerate(cheapest_assignment(costs)) if column is not None]

    assert len({column for _, column in assigned}) == len(assigned) == min(rows, columns)
    cheapest = min(sum(costs[row][column] for row, column in pairs) for pairs in tries)
    assert sum(costs[row][column] for row, column in assigned) == pytest.approx(cheapest, abs=1e-9)


def test_tour_begins_where_the_rest_of_the_way_is_short():
    # 1.0 m to the left, or 1.1 m ahead and two more behind it, which a rival would have if the hunter came late
    stops = [((0.0, 1.0), 9.0), ((1.1, 0.0), 9.0), ((1.9, 0.0), 1.2), ((2.7, 0.0), 1.6)]
    limits = Limits.of(ArenaConfig())
    assert best_tour(stops, limits) == [(1.1, 0.0), (1.9, 0.0), (2.7, 0.0), (0.0, 1.0)]
    assert best_tour([((2.0, 0.0), 0.1)], limits) == []


@given(st.lists(st.tuples(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), st.floats(0, 9)), max_size=4, unique=True))
def test_a_tour_is_the_best_of_all_orders(stops):
    """Tried one by one; each stop is passed in time."""
    limits = Limits.of(ArenaConfig())

    def worth(order):
        ahead = aside = heading = now_s = total = 0.0
        for (forward, left), until_s in order:
            now_s += leg_s(ahead, aside, heading, (forward, left), limits)
            if now_s > until_s:
                return 0.0
            heading = math.atan2(left - aside, forward - ahead)
            ahead, aside, total = forward, left, total + math.exp(-now_s / PATIENCE_S)
        return total

    stops = [(place, until_s) for place, until_s in stops if leg_s(0.0, 0.0, 0.0, place, limits) <= until_s]
    assume(len({place for place, _ in stops}) == len(stops))
    until = dict(stops)
    best = max(worth(order) for count in range(len(stops) + 1) for order in permutations(stops, count))
    assert worth([(place, until[place]) for place in best_tour(stops, limits)]) == pytest.approx(best)


def test_voronoi_prefers_a_target_of_its_own_in_company():
    alone, together = (0.0, 1.9), [(0.0, -2.0), (0.3, -2.2), (-0.3, -2.2)]
    assert turn_of("voronoi", view([alone, *together], control="velocity")) < 0.0
    assert turn_of("triage", view([alone, *together], control="velocity")) > 0.0
    # what rivals reach first is no company
    rivals = [(-0.4, -2.6), (0.2, -2.6)]
    assert turn_of("voronoi", view([alone, *together], rivals, control="velocity")) > 0.0


def test_spoiler_goes_where_the_leader_wants_to_go():
    left, right, rivals = (0.0, 1.5), (0.0, -1.6), [(-1.5, -2.9), (-1.5, 2.9)]
    for ahead, side in (([5.0, -1.0, 0.0], -1.0), ([-1.0, 5.0, 0.0], 1.0)):
        seen = view([left, right], rivals, differences=ahead, control="velocity")
        assert leading_rival(seen).rank == (1 if side < 0.0 else 2)
        assert turn_of("spoiler", seen) == side
    assert leading_rival(view([left])) is None


def test_pure_pursuit_drives_the_arc_that_passes_through_a_point():
    limits = Limits.of(ArenaConfig())
    for point in ((2.0, 1.0), (0.5, -0.4), (0.1, 0.7)):
        speed, turn = follow(point, limits)
        radius = speed * limits.max_speed_mps / (turn * limits.max_turn_rate_radps)
        assert math.hypot(point[0], point[1] - radius) == pytest.approx(abs(radius))
        assert max(speed, abs(turn)) == pytest.approx(1.0)
    assert follow((-1.0, -0.1), limits) == (0.0, -1.0)
    assert follow((0.0, 0.0), limits) == (0.0, 0.0)


def test_pid_slows_down_towards_a_target_and_begins_anew_with_another():
    made = agent("pid")
    assert made.act(view([(3.0, 0.0)], control="velocity"))[0] == 1.0
    near, _ = made.act(view([(0.5, 0.0)], control="velocity"))
    again, _ = made.act(view([(0.5, 0.0)], control="velocity"))
    assert 0.5 < near < again < 0.6
    assert made.act(view([(0.0, 0.9)], control="velocity"))[0] == pytest.approx(0.0, abs=1e-9)
    assert made.linear.integral == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", ["many", "alone", "blurred"])
def test_whatever_is_in_view_those_that_drive_themselves_act_legally_and_alike(name):
    """On what up to four of the hunters see, while `triage` drives them all."""
    config = {
        "many": scenario(
            "standard", hunters=64, max_targets=64, initial_targets=64, observed_targets=64, observed_hunters=63
        ),
        "alone": scenario("standard", hunters=1, initial_targets=0),
        "blurred": scenario("fog", view_noise_m=0.3),
    }[name]
    config = config.replace(control="velocity", max_cycles=2 if name == "many" else 15)
    env = parallel_env(config)
    observations, _ = env.reset(seed=6)
    looking = config.hunter_names[:: max(1, config.hunters // 4)]
    twins = {(hunter, driver): (agent(driver), agent(driver)) for hunter in looking for driver in DRIVING}
    limits = {hunter: Limits.of(config, seat) for seat, hunter in enumerate(config.hunter_names)}
    looks = 0
    while env.agents:
        views = {
            hunter: View(observations[hunter].tolist(), (), limits[hunter]) for hunter in env.agents if hunter in limits
        }
        for (hunter, _), both in twins.items():
            if hunter in views:
                one, other = (twin.act(views[hunter]) for twin in both)
                env.check_action(hunter, one)
                assert one == other
                looks += 1
        actions = {prey: np.zeros(2, dtype=np.float32) for prey in config.prey_names}
        observations, *_ = env.step(actions | {hunter: agent("triage").act(seen) for hunter, seen in views.items()})
    assert looks > 0


def test_random_follows_from_its_seed_alone():
    seen = view([(1.0, 0.0), (2.0, 0.0), (3.0, 0.0)])

    def choices(seed: int) -> list[int]:
        made = agent("random", seed)
        return [made.act(seen) for _ in range(50)]

    assert choices(1) == choices(1) != choices(2)
    assert set(choices(1)) == {0, 1, 2, 3}


def test_who_leads_a_fleeing_target_beats_who_follows_it(monkeypatch):
    """The same agent, but for where it aims; seats are taken in turn."""
    leads, follows = (runpy.run_path(intercept.__file__) for _ in range(2))
    monkeypatch.setitem(follows["meeting_point"].__globals__, "LONGEST_LEAD_S", 0.0)
    config, scores = scenario("evasive", hunters=2, time_limit_s=30), Counter[str]()
    for seed in range(20):
        seated = [("leads", leads), ("follows", follows)][:: 1 if seed % 2 else -1]
        result = play_match(config, seed, [module["Agent"]() for _, module in seated], [name for name, _ in seated])
        scores.update({name: score for (name, _), score in zip(seated, result.scores, strict=True)})
    assert scores["leads"] > 1.1 * scores["follows"]
