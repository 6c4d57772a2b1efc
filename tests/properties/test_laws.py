"""The laws that follow from the rulebook, on cases and matches that hypothesis looks for.

test_engine_equals_oracle.py has rows of a batch, test_keeping.py restored states.
"""

import itertools
from collections import Counter, defaultdict
from random import Random
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle.arena import OracleArena
from oracle.arithmetic import wrap
from oracle.turtles import Hunter, Turtle, distance, micrometres
from properties.matches import EFFORT, settings_of, some_batch_actions, some_config, some_pose, some_seed

from catch_arena.arbitration import arbitrate
from catch_arena.config import ArenaConfig
from catch_arena.engine import Engine
from catch_arena.verdicts import Ruling, Verdict

Case = dict[str, Any]

AMONG_ELIGIBLE = {Verdict.GRANTED, Verdict.KILL_FAILED, Verdict.LOST_CONTEST}
"""The verdicts of those who may catch the target, were it not for each other."""
WON = {Verdict.GRANTED, Verdict.KILL_FAILED}
UNCONTESTED = {Verdict.OUT_OF_REACH, Verdict.WAITING_FOR_PARTNER}
"""The refusals after which the distance is evidence."""
SEEDS = st.integers(0, 2**64 - 1)
SOURCES = st.randoms(use_true_random=False)
"""Every number that matches.py draws is chosen, and made simpler where a law fails, by hypothesis."""
MATCHES = settings(max_examples=settings().max_examples // 4)
"""Matches take longer than single steps."""
STEPS = 15


@st.composite
def cases(draw: st.DrawFn, policies: tuple[str, ...] = ("nearest", "first_come", "capstone")) -> Case:
    """Arguments of `arbitrate`: small grids, on which ties abound, with every circumstance."""
    grid = draw(st.sampled_from([1e-6, 0.05, 0.1, 0.15]))
    spots = st.tuples(st.integers(-3, 3), st.integers(-3, 3)).map(lambda spot: (grid * spot[0], grid * spot[1]))
    hunters = draw(st.lists(spots, min_size=1, max_size=6))
    targets = {f"t{place}": spot for place, spot in enumerate(draw(st.lists(spots, max_size=4)))}
    seats = st.integers(0, len(hunters) - 1)
    names: Any = st.sampled_from([*targets, *targets, "gone", "nobody", "", None])
    policy = draw(st.sampled_from(policies))
    return draw(st.just({}) if policy == "capstone" else partners(len(hunters))) | {
        "hunters": hunters,
        "targets": targets,
        "requests": draw(st.lists(st.tuples(seats, names), max_size=10)),
        "reach_m": draw(st.sampled_from([0.3, 0.2, 3e-6])),
        "policy": policy,
        "seed": draw(SEEDS),
        "step": draw(st.integers(0, 2**40)),
        "caught": ["gone"],
        "inactive": draw(st.lists(seats, max_size=2)),
        "kill_service_up": draw(st.integers(0, 9)) > 0,
        "kill_refused": [name for name in targets if draw(st.integers(0, 4)) == 0],
        "match_over": draw(st.integers(0, 19)) == 0,
    }


def partners(hunters: int) -> st.SearchStrategy[Case]:
    """Two teams, and how many hunters of one a catch needs (R5.10); or neither."""
    teams = [list(range(hunters))[::2], list(range(hunters))[1::2]]
    needed = st.integers(1, len(teams[0]))
    return st.just({}) | needed.map(lambda number: {"teams": list(filter(None, teams)), "hunters_per_catch": number})


def by_hunter(rulings: list[Ruling]) -> dict[int, list[Ruling]]:
    """Each hunter's rulings in their order."""
    found = defaultdict(list)
    for ruling in rulings:
        found[ruling.hunter].append(ruling)
    return dict(found)


def tied_for(rulings: list[Ruling]) -> dict[object, set[int]]:
    """The hunters among whom a lot has to decide, by target."""
    claims = defaultdict(list)
    for ruling in rulings:
        if ruling.verdict in AMONG_ELIGIBLE:
            claims[ruling.target].append((ruling.distance_um, ruling.hunter))
    nearest = {target: min(distance for distance, _ in claim) for target, claim in claims.items()}
    tied = {
        target: {hunter for distance, hunter in claim if distance == nearest[target]}
        for target, claim in claims.items()
    }
    return {target: hunters for target, hunters in tied.items() if len(hunters) > 1}


# ---- one step, by name ----


@given(case=cases())
def test_every_request_gets_one_ruling(case: Case) -> None:
    """R5.2, R5.6: in the order of the requests, and with the evidence that its verdict has."""
    rulings = arbitrate(**case)
    assert [(ruling.hunter, ruling.target) for ruling in rulings] == case["requests"]
    for ruling in rulings:
        tested = ruling.verdict in AMONG_ELIGIBLE | UNCONTESTED and case["policy"] != "capstone"
        assert (ruling.distance_um is not None) == tested
        assert ruling.success == (ruling.verdict is Verdict.GRANTED)
        if ruling.success:
            assert ruling.winner == ruling.hunter


@given(case=cases(policies=("nearest", "first_come")))
def test_a_target_is_granted_at_most_once_and_to_whom_all_its_losers_name(case: Case) -> None:
    """R5.6, R5.8: and a contest always has a winner."""
    claims = defaultdict(list)
    for ruling in arbitrate(**case):
        if ruling.verdict in AMONG_ELIGIBLE:
            claims[ruling.target].append(ruling)
    for rulings in claims.values():
        assert sum(ruling.verdict in WON for ruling in rulings) == 1
        if len(rulings) > 1:
            (winner,) = {ruling.winner for ruling in rulings}
            assert next(ruling.hunter for ruling in rulings if ruling.verdict in WON) == winner


@given(case=cases(), data=st.data())
def test_the_order_of_different_hunters_requests_never_matters(case: Case, data: st.DataObject) -> None:
    """R5.1: each hunter's own requests stay in their order, since the first stands."""
    waiting = {seat: iter([request for request in case["requests"] if request[0] == seat]) for seat in range(6)}
    order = data.draw(st.permutations([seat for seat, _ in case["requests"]]))
    other = {**case, "requests": [next(waiting[seat]) for seat in order]}
    assert by_hunter(arbitrate(**other)) == by_hunter(arbitrate(**case))


@given(case=cases(policies=("nearest", "capstone")), data=st.data())
def test_seats_are_labels(case: Case, data: st.DataObject) -> None:
    """R5.1, R5.5: who sits where changes nothing, but where a lot decides; and then one of the tied wins."""
    seat_of: list[int] = data.draw(st.permutations(range(len(case["hunters"]))))
    other = {
        **case,
        "hunters": [case["hunters"][seat_of.index(seat)] for seat in range(len(seat_of))],
        "requests": [(seat_of[seat], name) for seat, name in case["requests"]],
        "inactive": [seat_of[seat] for seat in case["inactive"]],
        "teams": [[seat_of[seat] for seat in team] for team in case["teams"]] if "teams" in case else None,
    }
    rulings, seated = arbitrate(**case), arbitrate(**other)
    tied = {} if case["policy"] == "capstone" else tied_for(rulings)
    for ruling, its in zip(rulings, seated, strict=True):
        assert (its.hunter, its.distance_um) == (seat_of[ruling.hunter], ruling.distance_um)
        if ruling.verdict in AMONG_ELIGIBLE and ruling.target in tied:
            assert its.verdict in AMONG_ELIGIBLE
            assert ruling.winner in tied[ruling.target]
            assert its.winner in {seat_of[hunter] for hunter in tied[ruling.target]}
        else:
            assert its.verdict is ruling.verdict
            assert its.winner == (None if ruling.winner is None else seat_of[ruling.winner])


@given(case=cases(policies=("nearest", "first_come")), data=st.data())
def test_taking_a_loser_away_changes_nothing_for_the_others(case: Case, data: st.DataObject) -> None:
    """R5.5: nor does anybody who was not eligible; R5.6 alone asks whether a refused kill was contested. A loser that
    is a partner (R5.10) may be needed.
    """
    rulings = by_hunter(arbitrate(**case))
    needed = WON | {Verdict.LOST_CONTEST} if case.get("hunters_per_catch", 1) > 1 else WON
    losers = [hunter for hunter, its in rulings.items() if not any(ruling.verdict in needed for ruling in its)]
    if not losers:
        return
    loser = data.draw(st.sampled_from(losers))
    left = by_hunter(arbitrate(**{**case, "requests": [r for r in case["requests"] if r[0] != loser]}))
    assert left.keys() == rulings.keys() - {loser}
    for hunter, its in left.items():
        for ruling, before in zip(its, rulings[hunter], strict=True):
            assert (ruling.verdict, ruling.distance_um) == (before.verdict, before.distance_um)
            assert ruling.winner == before.winner or ruling.verdict is Verdict.KILL_FAILED


@given(case=cases(policies=("nearest", "first_come")), data=st.data(), share=st.floats(0, 1))
def test_moving_closer_never_loses(case: Case, data: st.DataObject, share: float) -> None:
    """R5.3, R5.4: a hunter that asks for the same target from nearer fares no worse."""
    known = [(i, request) for i, request in enumerate(case["requests"]) if request[1] in case["targets"]]
    if not known:
        return
    i, (hunter, name) = data.draw(st.sampled_from(known))
    (x, y), (target_x, target_y) = case["hunters"][hunter], case["targets"][name]
    hunters = list(case["hunters"])
    hunters[hunter] = (x + share * (target_x - x), y + share * (target_y - y))
    before = arbitrate(**case)[i]
    after = arbitrate(**{**case, "hunters": hunters})[i]
    if before.distance_um is None:
        assert after == before
        return
    assert after.distance_um is not None
    assert after.distance_um <= before.distance_um
    assert after.verdict in WON or before.verdict not in WON
    assert after.verdict in AMONG_ELIGIBLE or before.verdict not in AMONG_ELIGIBLE


@given(case=cases(policies=("nearest", "first_come")))
def test_a_target_is_contested_by_teams_with_enough_hunters_alone(case: Case) -> None:
    """R5.10: a team's requests for a target that fail no earlier test all wait, or there are enough of them."""
    needed = case.get("hunters_per_catch", 1)
    team_of = {seat: team for team, seats in enumerate(case.get("teams", ())) for seat in seats}
    together = defaultdict(list)
    for ruling in arbitrate(**case):
        if ruling.verdict in AMONG_ELIGIBLE | {Verdict.WAITING_FOR_PARTNER}:
            together[ruling.target, team_of.get(ruling.hunter, ruling.hunter)].append(ruling)
    for rulings in together.values():
        waiting = [ruling.verdict is Verdict.WAITING_FOR_PARTNER for ruling in rulings]
        assert all(waiting) == any(waiting) == (len(rulings) < needed)
        assert all(ruling.winner is None for ruling in rulings if ruling.verdict is Verdict.WAITING_FOR_PARTNER)


CHI_SQUARE = {1: 10.83, 2: 13.82, 15: 37.70}
"""Quantile that a fair lot exceeds once in a thousand, by degrees of freedom."""


@pytest.mark.rule("R5.5", "R5.9")
@pytest.mark.parametrize(("policy", "claimants"), [("nearest", 2), ("nearest", 3), ("nearest", 16), ("first_come", 3)])
def test_r5_5_the_lot_favours_no_seat(policy: Any, claimants: int) -> None:
    """A chi-square test over 2,000 keys: neighbouring seeds, steps and target numbers, all hunters at one place."""
    wins: Counter[int | None] = Counter()
    keys = list(itertools.product(range(20 * EFFORT), range(10), range(10)))
    for seed, step, number in keys:
        rulings = arbitrate(
            hunters=[(0.0, 0.0)] * claimants,
            targets={f"t{place}": (0.1, 0.0) for place in range(10)},
            requests=[(seat, f"t{number}") for seat in range(claimants)],
            policy=policy,
            seed=seed,
            step=10 * step + number if policy == "first_come" else step,
        )
        wins[rulings[0].winner] += 1
    expected = len(keys) / claimants
    assert sum(wins[seat] for seat in range(claimants)) == len(keys)
    assert sum((wins[seat] - expected) ** 2 / expected for seat in range(claimants)) < CHI_SQUARE[claimants - 1]


# ---- whole matches ----


@MATCHES
@given(source=SOURCES, seed=SEEDS, actions=SEEDS)
def test_nothing_is_lost_and_nothing_caught_twice(source: Random, seed: int, actions: int) -> None:
    """R5.8, R3.1, R3.4 to R3.6, R5.2: catches + alive = spawned, every firing and every number is accounted for, and
    who requests gets one ruling.
    """
    config = some_config(source)
    engine = Engine(config)
    engine.reset([seed])
    chosen = Random(actions)
    credited: list[object] = []
    for _ in range(STEPS):
        actions = some_batch_actions(chosen, config, 1)
        engine.step(*actions)
        choices = actions[0]
        rulings = {ruling.hunter: ruling for ruling in engine.world(0).rulings}
        assert len(rulings) == len(engine.world(0).rulings)
        for seat, control in enumerate(config.controls):
            if control == "full":
                assert (seat in rulings) == (choices[0, seat] > 0)
        time, _, spawned, used, firings, *_, refused = engine.state(0)[:8].tolist()
        world = engine.world(0)
        numbers = [target.number for target in world.targets]
        assert numbers == sorted(set(numbers))
        assert len(numbers) <= config.max_targets
        assert spawned == used - refused
        assert firings == (time // config.spawn_period_ms if config.spawning else 0)
        if config.policy != "capstone":
            credited += [ruling.target for ruling in rulings.values() if ruling.success]
            assert len(set(credited)) == len(credited) == sum(hunter.score for hunter in world.hunters)
            assert len(credited) + len(numbers) == spawned
            assert not {config.target_name(number) for number in numbers} & set(credited)
        if engine.ends[0]:
            break


@MATCHES
@given(source=SOURCES, seed=SEEDS, actions=st.tuples(SEEDS, SEEDS))
def test_places_are_common_to_all_who_play_a_seed(source: Random, seed: int, actions: tuple[int, int]) -> None:
    """R3.3, R3.6: the k-th place and its refusal are the same whatever the hunters can do and do; where it goes from
    there is another matter. Prey that returns takes its number and place without faults (R12.3), so that they can be
    those of a refusal in another match.
    """
    config = some_config(source)
    changed = config.replace(
        reach_m=source.choice([1e-7, 1.0, 5.0]), policy=source.choice(["nearest", "first_come"]), control="full"
    )
    appeared: list[dict[int, tuple[float, float, float]]] = []
    used = []
    for settings_, chosen in ((config, Random(actions[0])), (changed, Random(actions[1]))):
        engine = Engine(settings_)
        engine.reset([seed])
        places = {}
        for step in range(STEPS + 1):
            if step > 0:
                engine.step(*some_batch_actions(chosen, settings_, 1))
            for target in engine.world(0).targets:
                places.setdefault(target.number, (target.x, target.y, target.theta))
        appeared.append(places)
        used.append(int(engine.state(0)[3]))
    for number in range(1, min(used) + 1):
        if not config.prey or all(number in places for places in appeared):
            assert appeared[0].get(number) == appeared[1].get(number), f"target {number}"


@MATCHES
@given(source=SOURCES, actions=SEEDS, data=st.data())
def test_seats_are_labels_for_whole_matches(source: Random, actions: int, data: st.DataObject) -> None:
    """R5.1, R7.1: the same hunters in other seats see, do and earn the same, up to the first lot; errors of the view
    (R7.6) and dropouts (R1.7) are lots from the first step on.
    """
    config = some_config(source).replace(view_noise_m=0.0, dropout_rate=0.0)
    if config.policy == "first_come":
        config = config.replace(policy="nearest")
    poses = tuple(some_pose(source, config.side_m) for _ in range(config.hunters))
    order = np.array(data.draw(st.permutations(range(config.hunters))))
    by_seat: dict[str, tuple[Any, ...]] = {
        "hunter_poses": poses,
        "control": config.controls,
        "max_speed_mps": config.max_speeds,
        "max_turn_rate_radps": config.max_turn_rates,
        "reach_m": config.reaches,
    }
    one = Engine(config.replace(**by_seat))
    elsewhere: dict[str, Any] = {name: tuple(given[seat] for seat in order) for name, given in by_seat.items()}
    if config.teams is not None:
        elsewhere["teams"] = tuple(tuple(order.tolist().index(seat) for seat in team) for team in config.teams)
    other = Engine(config.replace(**elsewhere))
    seed = some_seed(source)
    one.reset([seed])
    other.reset([seed])
    chosen = Random(actions)
    for _ in range(STEPS):
        assert np.array_equal(other.views.hunters[0, :, :15, 0], one.views.hunters[0, order, :15, 0])
        rows = [*order, *range(config.hunters, config.hunters + config.prey)]
        assert np.array_equal(other.observations[0], one.observations[0, rows])
        assert np.array_equal(other.masks[0], one.masks[0, order])
        assert np.array_equal(other.parts[0], one.parts[0, order])
        # a team's rewards are added up by seat
        same = np.allclose if config.team_share else np.array_equal
        assert same(other.rewards[0], one.rewards[0, rows])
        assert other.world(0).targets == one.world(0).targets
        if has_tied_threats(one, config):
            break
        choices, commands = some_batch_actions(chosen, config, 1)
        one.step(choices, commands)
        other.step(choices[:, order], commands[:, rows])
        if config.policy == "nearest" and tied_for(list(one.world(0).rulings)):
            break


def has_tied_threats(engine: Engine, config: ArenaConfig) -> bool:
    """R3.10, R12.5: whether a lot decides from whom a target flees, or which hunter is the nearest to prey."""
    world = engine.world(0)
    for target in world.targets:
        if config.target_motion != "flee" and target.prey is None:
            continue
        away = sorted(
            micrometres(distance(target.x, target.y, hunter.x, hunter.y))
            for hunter in world.hunters
            if not hunter.withdrawn
        )
        if len(away) > 1 and away[0] == away[1] and (target.prey is not None or away[0] < config.alarm_um):
            return True
    return False


@settings(MATCHES, max_examples=2 * MATCHES.max_examples)
@given(source=SOURCES, seed=SEEDS, actions=SEEDS)
def test_what_a_hunter_does_not_see_changes_nothing_for_it(source: Random, seed: int, actions: int) -> None:
    """R7.5: wherever else it stands, whoever looks has the same observation and the same mask, noise included."""
    config = with_partial_view(some_config(source), source)
    engine, other = Engine(config), Engine(config)
    chosen = Random(actions)
    for changed in (engine, other):
        changed.reset([seed])
    for _ in range(source.randint(0, 3)):
        actions_of_all = some_batch_actions(chosen, config, 1)
        engine.step(*actions_of_all)
        other.step(*actions_of_all)
    hunters, prey = (
        [some_pose(source, config.side_m) for _ in range(count)] for count in (config.hunters, config.prey)
    )
    room = config.max_targets - config.prey
    targets = [some_pose(source, config.side_m)[:2] for _ in range(source.randint(min(1, room), room))]
    seat = source.randrange(config.hunters)
    x, y, theta = hunters[seat]
    me, eyes = Hunter(seat, x, y, wrap(theta)), OracleArena(config.to_dict())  # its heading as `place` takes it

    def elsewhere(pose: tuple[float, ...]) -> tuple[float, ...]:
        """Another place that the hunter does not see either, if there is one."""
        for _ in range(5):
            x, y, theta = some_pose(source, config.side_m)
            if not eyes._sees(me, Turtle(x, y, theta)):
                return (x, y, theta)[: len(pose)]
        return pose

    moved_hunters: list[Any] = [
        pose if who == seat or eyes._sees(me, Turtle(*pose)) else elsewhere(pose) for who, pose in enumerate(hunters)
    ]
    moved_targets: list[Any] = [place if eyes._sees(me, Turtle(*place, 0.0)) else elsewhere(place) for place in targets]
    moved_prey: list[Any] = [pose if eyes._sees(me, Turtle(*pose)) else elsewhere(pose) for pose in prey]
    engine.place(0, hunters, targets, prey)
    other.place(0, moved_hunters, moved_targets, moved_prey)
    assert np.array_equal(other.observations[0, seat], engine.observations[0, seat]), settings_of(config)
    assert np.array_equal(other.masks[0, seat], engine.masks[0, seat])


def with_partial_view(config: ArenaConfig, source: Random) -> ArenaConfig:
    """Return the config with a view that leaves something out."""
    return config.replace(
        policy="nearest",
        view_radius_m=source.choice([None, 0.3 * config.side_m, 0.6 * config.side_m]),
        view_angle_deg=source.choice([60.0, 90.0, 180.0, 270.0]),
    )
