"""Chapter 5: the arbiter. In the arena by rank; by name through `arbitrate` and the oracle's `judge`."""

import itertools
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oracle.arithmetic import SERVICE_LOT, TIE_LOT, draw, key
from rulebook.conftest import Arbiter, ArenaFactory, oracle_arbiter

from catch_arena.arbitration import arbitrate
from catch_arena.errors import ConfigError
from catch_arena.verdicts import Ruling, Verdict

STILL = (0.0, 0.0)


def verdicts(rulings: list[Ruling]) -> list[Verdict]:
    return [ruling.verdict for ruling in rulings]


# ---- R5.1 ----


@pytest.mark.rule("R5.1")
def test_r5_1_eligibility_is_read_from_the_state_before_the_step(arena: ArenaFactory) -> None:
    """Rank 1 of both hunters is the same target: one wins it, the other is not moved on to the next target."""
    match = arena(hunters=2, control="full")
    match.place(hunters=[(5.0, 5.0, 0.0), (5.0, 5.1, 0.0)], targets=[(5.0, 5.0), (5.0, 5.2)])
    match.step((STILL, 1), (STILL, 1))
    assert match.evidence() == [(Verdict.GRANTED, 1, 0, 0), (Verdict.LOST_CONTEST, 1, 100_000, 0)]
    assert match.alive == [2]


# ---- R5.2 ----

CALM: dict[str, Any] = {"hunters": [(1.0, 1.0), (1.1, 1.0)], "targets": {"a": (1.0, 1.0), "far": (9.0, 9.0)}}


@pytest.mark.rule("R5.2")
@pytest.mark.parametrize("name", [None, 7, 1.5, b"a", ["a"], {"a": 1}, math.nan, "x" * 256])
def test_r5_2_what_is_no_name_is_malformed(arbiter: Arbiter, name: object) -> None:
    """Neither a string nor short enough; and it counts as the hunter's request of the step."""
    rulings = arbiter(**CALM, requests=[(0, name), (0, "a")])
    assert verdicts(rulings) == [Verdict.MALFORMED, Verdict.DUPLICATE]
    assert rulings[0].target is name
    assert rulings[0].distance_um is rulings[0].winner is None


@pytest.mark.rule("R5.2")
@pytest.mark.parametrize("name", ["", "x" * 255, "A", "a ", "žel", "\x00"])
def test_r5_2_any_string_of_up_to_255_characters_is_a_name(arbiter: Arbiter, name: str) -> None:
    """Unknown, but well formed."""
    assert verdicts(arbiter(**CALM, requests=[(0, name)])) == [Verdict.UNKNOWN_TARGET]
    at_hand = arbiter(hunters=[(1.0, 1.0)], targets={name: (1.0, 1.0)}, requests=[(0, name)])
    assert verdicts(at_hand) == [Verdict.GRANTED]


BOOK = (Path(__file__).parents[2] / "docs" / "reference" / "rulebook.md").read_text(encoding="utf-8")
ORDER = [Verdict[name] for name in re.findall(r"^\| ([A-Z_]+) \|", BOOK, flags=re.MULTILINE)]
"""R5.2's table."""

REASONS_AGAINST: dict[Verdict, dict[str, Any]] = {
    Verdict.MATCH_OVER: {"match_over": True},
    Verdict.MALFORMED: {"name": None},
    Verdict.HUNTER_INACTIVE: {"inactive": [1]},
    Verdict.DUPLICATE: {"earlier": [(1, "b")]},
    Verdict.UNKNOWN_TARGET: {"name": "nobody"},
    Verdict.ALREADY_CAUGHT: {"name": "gone"},
    Verdict.SERVICE_DOWN: {"kill_service_up": False},
    Verdict.OUT_OF_REACH: {"reach_m": 0.07},
    Verdict.WAITING_FOR_PARTNER: {"hunters_per_catch": 2},
    Verdict.LOST_CONTEST: {"earlier": [(0, "a")]},
    Verdict.KILL_FAILED: {"kill_refused": ["a"]},
    Verdict.GRANTED: {},
}
"""Circumstances in which hunter 1, 0.1 m from the target, gets each verdict."""


@pytest.mark.rule("R5.2")
@pytest.mark.parametrize(
    ("earlier", "later"),
    [
        (earlier, later)
        for earlier, later in itertools.combinations(ORDER, 2)
        # a request has one name
        if not ("name" in REASONS_AGAINST[earlier] and "name" in REASONS_AGAINST[later])
    ],
    ids=lambda verdict: verdict.name,
)
def test_r5_2_the_tests_are_made_in_the_order_of_the_table(arbiter: Arbiter, earlier: Verdict, later: Verdict) -> None:
    """The first of two reasons in the table gives the verdict, though each would do alone."""

    def verdict_for(*reasons: Verdict) -> Verdict:
        case: dict[str, Any] = {"name": "a", "earlier": []}
        for reason in reasons:
            against = REASONS_AGAINST[reason]
            case |= against | {"earlier": [*case["earlier"], *against.get("earlier", [])]}
        requests = [*case.pop("earlier"), (1, case.pop("name"))]
        near = {"hunters": [(1.0, 1.05), (1.0, 1.1), (9.0, 9.0)], "targets": {"a": (1.0, 1.0), "b": (1.0, 1.2)}}
        return arbiter(**near, teams=[(0,), (1, 2)], caught=["gone"], requests=requests, **case)[-1].verdict

    assert verdict_for(later) is later
    assert verdict_for(earlier) is earlier
    assert verdict_for(earlier, later) is earlier
    assert verdict_for(later, earlier) is earlier


@pytest.mark.rule("R5.2")
def test_r5_2_the_verdicts_are_numbered_in_the_order_of_the_table() -> None:
    """From 1, all but the one that came later: it is tested before LOST_CONTEST, and has the next number."""
    numbered = [(verdict.name, verdict.value) for verdict in Verdict]
    of_table = re.findall(r"^\| ([A-Z_]+) \| (\d+) \|", BOOK, flags=re.MULTILINE)
    assert sorted(numbered) == sorted((name, int(number)) for name, number in of_table)
    first = [verdict for verdict in ORDER if verdict is not Verdict.WAITING_FOR_PARTNER]
    assert [verdict.value for verdict in first] == list(range(1, 12))
    assert ORDER.index(Verdict.WAITING_FOR_PARTNER) == ORDER.index(Verdict.LOST_CONTEST) - 1
    assert Verdict.WAITING_FOR_PARTNER.value == 12


@pytest.mark.rule("R5.2")
@pytest.mark.parametrize("verdict", Verdict, ids=lambda verdict: verdict.name)
def test_r5_2_each_verdict_cites_a_clause_of_the_book(verdict: Verdict) -> None:
    """In its words too, which commands and pages print."""
    assert re.search(rf"^#+ {re.escape(verdict.clause)} ", BOOK, flags=re.MULTILINE)
    assert verdict.reason.endswith(f" ({verdict.clause})")
    assert Verdict(verdict.value) is verdict


@pytest.mark.rule("R5.2")
@pytest.mark.parametrize("control", ["target", "full"])
def test_r5_2_a_rank_without_a_target_is_malformed_and_the_hunter_holds(arena: ArenaFactory, control: str) -> None:
    """Zero velocity, no active target, no integrals."""
    match = arena(control=control)
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(7.0, 5.0)])
    match.step(1 if control == "target" else ((1.0, 1.0), 1))
    assert match.hunter().v > 0
    before = match.hunter()[:3]
    match.step(2 if control == "target" else ((1.0, 1.0), 2))
    assert match.evidence() == [(Verdict.MALFORMED, None, None, None)]
    assert match.hunter()[:3] == before
    assert match.hunter()[3:8] == (0.0,) * 5


@pytest.mark.rule("R5.2")
def test_r5_2_malformed_goes_before_inactive_in_the_arena_too(arena: ArenaFactory) -> None:
    """A withdrawn hunter that names a rank without a target."""
    match = arena(hunters=2, control="full")
    match.place(hunters=[(5.0, 5.0, 0.0), (8.0, 8.0, 0.0)], targets=[(5.1, 5.0)])
    match.withdraw(0)
    match.step((STILL, 2), (STILL, 0))
    assert match.verdicts[0] is Verdict.MALFORMED


# ---- R5.3 ----


@pytest.mark.rule("R5.3")
def test_r5_3_299999_micrometres_are_in_and_300000_are_out(arbiter: Arbiter) -> None:
    """Along an axis and at an angle."""
    for micrometre, verdict in ((299_999, Verdict.GRANTED), (300_000, Verdict.OUT_OF_REACH)):
        for bearing in (0.0, math.pi / 2, 2.2):
            x, y = 1e-6 * micrometre * math.cos(bearing), 1e-6 * micrometre * math.sin(bearing)
            (ruling,) = arbiter(hunters=[(0.0, 0.0)], targets={"a": (x, y)}, requests=[(0, "a")])
            assert ruling.distance_um == micrometre
            assert ruling.verdict is verdict


@pytest.mark.rule("R5.3")
@pytest.mark.parametrize(("tenths", "micrometre"), [(2_999_994, 299_999), (2_999_996, 300_000), (4, 0), (6, 1)])
def test_r5_3_distance_is_rounded_to_the_nearest_micrometre(arbiter: Arbiter, tenths: int, micrometre: int) -> None:
    """In tenths of a micrometre."""
    (ruling,) = arbiter(hunters=[(0.0, 0.0)], targets={"a": (1e-7 * tenths, 0.0)}, requests=[(0, "a")])
    assert ruling.distance_um == micrometre


@pytest.mark.rule("R5.3")
def test_r5_3_the_arena_measures_the_same_way(arena: ArenaFactory) -> None:
    """Full control asks for both; target control does not even ask beyond the reach."""
    match = arena(control=("full", "target"), hunters=2)
    for micrometre, verdict in ((299_999, Verdict.GRANTED), (300_000, Verdict.OUT_OF_REACH)):
        gap = 1e-6 * micrometre
        match.reset(1)
        match.place(hunters=[(1.0, 1.0, 0.0), (5.0, 5.0, 0.0)], targets=[(1.0, 1.0 + gap), (5.0 + gap, 5.0)])
        match.step((STILL, 1), 1)
        assert match.evidence()[0] is not None
        assert match.evidence()[0].distance_um == micrometre
        assert match.verdicts == [verdict, verdict if verdict is Verdict.GRANTED else None]


@pytest.mark.rule("R5.3")
def test_r5_3_the_scenario_sets_the_reach(arbiter: Arbiter) -> None:
    """Strictly less, at any reach; below a micrometre it still holds the target itself."""
    for reach, gap, verdict in (
        (1.0, 0.999999, Verdict.GRANTED),
        (1.0, 1.0, Verdict.OUT_OF_REACH),
        (1e-9, 0.0, Verdict.GRANTED),
        (1e-9, 1e-6, Verdict.OUT_OF_REACH),
    ):
        (ruling,) = arbiter(hunters=[(0.0, 0.0)], targets={"a": (gap, 0.0)}, requests=[(0, "a")], reach_m=reach)
        assert ruling.verdict is verdict


# ---- R5.4 ----


@pytest.mark.rule("R5.4")
def test_r5_4_the_nearer_of_two_hunters_is_granted_the_target(arena: ArenaFactory) -> None:
    """Both stand within reach of one target and request it in the same step."""
    match = arena(hunters=2, control="full")
    match.place(hunters=[(5.0, 5.0, 0.0), (5.25, 5.0, 0.0)], targets=[(5.15, 5.0)])
    match.step((STILL, 1), (STILL, 1))
    assert match.verdicts == [Verdict.LOST_CONTEST, Verdict.GRANTED]
    assert match.scores == [0, 1]


# ---- R5.5 ----


def tie_lot(seed: int, step: int, number: int, seat: int) -> int:
    """R5.5's lot, from the appendix."""
    return draw(draw(draw(key(seed, TIE_LOT), step), number), seat)


@pytest.mark.rule("R5.5")
def test_r5_5_of_a_tie_the_lowest_lot_wins(arbiter: Arbiter) -> None:
    """Seeds, steps and the target's place among those given all enter it."""
    hunters = [(0.1, 0.0), (-0.1, 0.0), (0.0, 0.1)]
    seen = set()
    for seed, step, number in itertools.product((0, 1, 2**64 - 1), (0, 1, 599), (1, 2, 3)):
        targets = {f"t{place}": (0.0, 0.0) if place == number else (9.0, 9.0) for place in (1, 2, 3)}
        requests = [(seat, f"t{number}") for seat in (2, 0, 1)]
        rulings = arbiter(hunters=hunters, targets=targets, requests=requests, seed=seed, step=step)
        expected = min(range(3), key=lambda seat: tie_lot(seed, step, number, seat))
        assert {ruling.winner for ruling in rulings} == {expected}
        seen.add(expected)
    assert seen == {0, 1, 2}


@pytest.mark.rule("R5.5")
def test_r5_5_in_an_arena_the_lot_bears_seed_step_number_and_seat(arena: ArenaFactory) -> None:
    """Two hunters at one place, in several steps of several matches."""
    winners = []
    for seed in (3, 4, 5):
        match = arena(hunters=3, control="full", seed=seed)
        for step in range(4):
            match.reset(seed)
            match.hold(step)
            match.place(hunters=[(5.0, 5.0, 0.0)] * 3, targets=[*[(9.0, 9.0)] * (4 - step), (5.1, 5.0)])
            number = 5 - step
            match.step((STILL, 1), (STILL, 1), (STILL, 0))
            expected = min((0, 1), key=lambda seat: tie_lot(seed, step, number, seat))
            assert match.verdicts[expected] is Verdict.GRANTED
            assert match.evidence()[1 - expected] == (Verdict.LOST_CONTEST, number, 100_000, expected)
            winners.append(expected)
    assert set(winners) == {0, 1}


# ---- R5.6 ----


@pytest.mark.rule("R5.6")
def test_r5_6_losers_get_lost_contest_with_their_distance_and_the_winner(arbiter: Arbiter) -> None:
    """The evidence of a contest of three."""
    rulings = arbiter(
        hunters=[(0.2, 0.0), (0.1, 0.0), (0.0, 0.25)],
        targets={"a": (0.0, 0.0)},
        requests=[(2, "a"), (0, "a"), (1, "a")],
    )
    assert rulings == [
        Ruling(Verdict.LOST_CONTEST, 2, "a", 250_000, 1),
        Ruling(Verdict.LOST_CONTEST, 0, "a", 200_000, 1),
        Ruling(Verdict.GRANTED, 1, "a", 100_000, 1),
    ]


@pytest.mark.rule("R5.6")
def test_r5_6_a_distance_is_given_only_where_reach_was_tested(arbiter: Arbiter) -> None:
    """A winner is given only if there was a contest or a grant, not for one beyond the reach of a contested target."""
    case: dict[str, Any] = {"hunters": [(0.1, 0.0), (0.2, 0.0), (4.0, 0.0)], "targets": {"a": (0.0, 0.0)}}
    rulings = arbiter(**case, requests=[(0, "a"), (1, "a"), (2, "a"), (0, "a")])
    assert rulings[2] == Ruling(Verdict.OUT_OF_REACH, 2, "a", 4_000_000, None)
    assert rulings[3] == Ruling(Verdict.DUPLICATE, 0, "a", None, None)
    for circumstance in ({"match_over": True}, {"inactive": [0]}, {"kill_service_up": False}):
        (ruling,) = arbiter(**case, requests=[(0, "a")], **circumstance)
        assert ruling.distance_um is ruling.winner is None


@pytest.mark.rule("R5.6")
def test_r5_6_the_reasons_cite_their_clauses() -> None:
    """One reason for each verdict, and people are told the evidence."""
    reasons = {Ruling(verdict, 0, "a").reason for verdict in Verdict}
    assert len(reasons) == len(Verdict)
    shown = str(Ruling(Verdict.LOST_CONTEST, 2, "a", 250_000, 1))
    for part in ("hunter_2", "0.250000 m", "hunter_1", "LOST_CONTEST", "R5.6"):
        assert part in shown


# ---- R5.7 ----


@pytest.mark.rule("R5.7")
def test_r5_7_with_the_kill_service_down_nothing_changes(arena: ArenaFactory) -> None:
    """Every request of the step that names a target is SERVICE_DOWN."""
    match = arena(hunters=3, control="full", faults={"kill_down": 1.0})
    match.place(hunters=[(5.0, 5.0, 0.0), (5.1, 5.0, 0.0), (9.0, 9.0, 0.0)], targets=[(5.0, 5.1)])
    match.step((STILL, 1), (STILL, 1), (STILL, 1))
    assert match.evidence() == [(Verdict.SERVICE_DOWN, 1, None, None)] * 3
    assert match.alive == [1]
    assert match.scores == [0, 0, 0]


@pytest.mark.rule("R5.7")
def test_r5_7_a_kill_that_the_simulator_refuses_credits_nobody(arena: ArenaFactory) -> None:
    """The contest's winner gets KILL_FAILED, the loser LOST_CONTEST, and the target stays."""
    match = arena(hunters=2, control="full", faults={"kill_refused": 1.0})
    match.place(hunters=[(5.0, 5.0, 0.0), (5.2, 5.0, 0.0)], targets=[(5.0, 5.0)])
    match.step((STILL, 1), (STILL, 1))
    assert match.evidence() == [(Verdict.KILL_FAILED, 1, 0, 0), (Verdict.LOST_CONTEST, 1, 200_000, 0)]
    assert match.alive == [1]
    assert match.scores == [0, 0]
    match.step((STILL, 1), (STILL, 0))
    assert match.evidence() == [(Verdict.KILL_FAILED, 1, 0, None), None]


# ---- R5.8 ----


@pytest.mark.rule("R5.8")
def test_r5_8_catches_and_alive_add_up_to_spawned(arena: ArenaFactory) -> None:
    """After every step of a crowded match with faults, and no number is credited twice."""
    match = arena(
        hunters=4,
        control="full",
        reach_m=3.0,
        initial_targets=8,
        spawn_frequency_hz=20.0,
        max_targets=12,
        faults={"kill_down": 0.2, "kill_refused": 0.2, "spawn_refused": 0.2, "spawn_down": 0.1},
    )
    credited: list[int | None] = []
    for step in range(60):
        match.step(*(((0.5, 0.3 - 0.2 * seat), 1 + (step + seat) % 2) for seat in range(4)))
        assert sum(match.scores) + len(match.alive) == match.spawned
        credited += [found.number for found in match.evidence() if found and found.verdict is Verdict.GRANTED]
        assert len(credited) == len(set(credited)) == sum(match.scores)
        assert not set(credited) & set(match.alive)
    assert len(credited) > 30


# ---- R5.9 ----


def lot(seed: int, step: int, seat: int) -> int:
    """R5.9's lot, from the appendix."""
    return draw(draw(key(seed, SERVICE_LOT), step), seat)


@pytest.mark.rule("R5.9")
def test_r5_9_first_come_grants_whom_the_steps_lots_serve_first(arbiter: Arbiter) -> None:
    """Not the nearest; only the eligible ones count; and the order of the requests does not."""
    hunters = [(0.05, 0.0), (0.1, 0.0), (0.2, 0.0), (3.0, 0.0)]
    winners = set()
    for seed, step in itertools.product(range(10), range(3)):
        expected = min(range(3), key=lambda seat: lot(seed, step, seat))
        for requests in ([(seat, "a") for seat in range(4)], [(seat, "a") for seat in (3, 2, 1, 0)]):
            rulings = arbiter(
                hunters=hunters,
                targets={"a": (0.0, 0.0)},
                requests=requests,
                policy="first_come",
                seed=seed,
                step=step,
            )
            assert {ruling.winner for ruling in rulings if ruling.hunter != 3} == {expected}
            assert next(ruling for ruling in rulings if ruling.hunter == 3).verdict is Verdict.OUT_OF_REACH
        winners.add(expected)
    assert winners == {0, 1, 2}


@pytest.mark.rule("R5.9")
def test_r5_9_first_come_in_an_arena(arena: ArenaFactory) -> None:
    """One queue for all the targets of a step."""
    winners = set()
    for seed in range(6):
        match = arena(hunters=2, control="full", policy="first_come", seed=seed)
        for step in range(3):
            match.reset(seed)
            match.hold(step)
            match.place(hunters=[(5.0, 5.0, 0.0), (5.1, 5.0, 0.0)], targets=[(5.0, 5.0)])
            match.step((STILL, 1), (STILL, 1))
            expected = min((0, 1), key=lambda seat: lot(seed, step, seat))
            assert match.verdicts[expected] is Verdict.GRANTED
            assert match.verdicts[1 - expected] is Verdict.LOST_CONTEST
            winners.add(expected)
    assert winners == {0, 1}


# ---- R5.10 ----

TEAMS = ((0, 1), (2, 3))
NEAR = [(5.2, 5.0, 0.0), (5.0, 5.25, 0.0), (5.1, 5.0, 0.0), (5.0, 4.71, 0.0)]
"""Poses 0.20, 0.25, 0.10 and 0.29 m from (5, 5)."""
WAITS, GRANTED, LOST = Verdict.WAITING_FOR_PARTNER, Verdict.GRANTED, Verdict.LOST_CONTEST


@pytest.mark.rule("R5.10")
@pytest.mark.parametrize(
    ("asking", "expected", "scores"),
    [
        ((0,), {0: (WAITS, None)}, [0, 0, 0, 0]),
        ((0, 2), {0: (WAITS, None), 2: (WAITS, None)}, [0, 0, 0, 0]),
        ((0, 1), {0: (GRANTED, 0), 1: (LOST, 0)}, [1, 0, 0, 0]),
        ((0, 1, 2), {0: (GRANTED, 0), 1: (LOST, 0), 2: (WAITS, None)}, [1, 0, 0, 0]),
        ((0, 1, 2, 3), {0: (LOST, 2), 1: (LOST, 2), 2: (GRANTED, 2), 3: (LOST, 2)}, [0, 0, 1, 0]),
        ((0, 2, 3), {0: (WAITS, None), 2: (GRANTED, 2), 3: (LOST, 2)}, [0, 0, 1, 0]),
    ],
    ids=lambda part: "".join(map(str, part)) if isinstance(part, tuple) else "",
)
def test_r5_10_a_catch_needs_two_hunters_of_one_team(
    arena: ArenaFactory, asking: tuple[int, ...], expected: dict[int, Any], scores: list[int]
) -> None:
    """The nearest of the teams with enough wins and is credited alone; a hunter that waits is a refused one."""
    match = arena(
        control="full",
        hunters=4,
        teams=TEAMS,
        hunters_per_catch=2,
        rewards={"lost_contest": -1, "rejected_request": -9},
    )
    match.place(hunters=NEAR, targets=[(5.0, 5.0)])
    match.step(*((STILL, int(seat in asking)) for seat in range(4)))
    away = [200_000, 250_000, 100_000, 290_000]
    found = {seat: one for seat, one in enumerate(match.evidence()) if one is not None}
    assert found == {seat: (verdict, 1, away[seat], winner) for seat, (verdict, winner) in expected.items()}
    assert match.scores == scores
    assert match.alive == ([] if any(scores) else [1])
    paid = {GRANTED: 1, LOST: -1, WAITS: -9, None: 0}
    assert match.rewards == [paid[expected.get(seat, (None,))[0]] for seat in range(4)]


@pytest.mark.rule("R5.10")
def test_r5_10_waiting_lasts_for_one_step(arena: ArenaFactory) -> None:
    """Both must ask in the same step."""
    match = arena(control="full", hunters=2, teams=((0, 1),), hunters_per_catch=2)
    match.place(hunters=NEAR[:2], targets=[(5.0, 5.0)])
    for asking in ((1, 0), (0, 1), (0, 0)):
        match.step(*((STILL, rank) for rank in asking))
        assert match.scores == [0, 0]
    match.step((STILL, 1), (STILL, 1))
    assert match.scores == [1, 0]


@pytest.mark.rule("R5.10")
@pytest.mark.parametrize("needed", [1, 2, 3, 4])
def test_r5_10_that_many_and_no_fewer(arena: ArenaFactory, needed: int) -> None:
    """Three of a team of four ask for one target, the fourth for another; a hunter of another team is the nearest."""
    match = arena(control="full", hunters=5, teams=((4, 0, 2, 3), (1,)), hunters_per_catch=needed)
    spots = [(2.1, 2.0, 0.0), (2.05, 2.0, 0.0), (2.2, 2.0, 0.0), (2.0, 2.15, 0.0), (8.1, 8.0, 0.0)]
    match.place(hunters=spots, targets=[(2.0, 2.0), (8.0, 8.0)])
    match.step(*[(STILL, 1)] * 5)
    assert [one and one.number for one in match.evidence()] == [1, 1, 1, 1, 2]
    alone = WAITS if needed > 1 else GRANTED
    of_three = {1: [LOST] * 3, 2: [GRANTED, LOST, LOST], 3: [GRANTED, LOST, LOST], 4: [WAITS] * 3}[needed]
    assert match.verdicts == [of_three[0], alone, *of_three[1:], alone]


@pytest.mark.rule("R5.10", "R5.5", "R5.9")
@pytest.mark.parametrize("policy", ["nearest", "first_come"])
def test_r5_10_the_lot_is_among_those_who_do_not_wait(arbiter: Arbiter, policy: str) -> None:
    """Three are equally near; the third has no partner, whatever its lot."""
    case: dict[str, Any] = {
        "hunters": [(0.1, 0.0), (-0.1, 0.0), (0.0, 0.1)],
        "targets": {"a": (0.0, 0.0)},
        "requests": [(0, "a"), (1, "a"), (2, "a")],
        "policy": policy,
        "hunters_per_catch": 2,
        "teams": [(0, 1), (2,)],
    }
    winners = set()
    for seed in range(20):
        rulings = arbiter(**case, seed=seed)
        without = arbiter(**case | {"requests": case["requests"][:2]}, seed=seed)
        assert rulings[:2] == without
        assert rulings[2] == Ruling(WAITS, 2, "a", 100_000, None)
        winners.add(rulings[0].winner)
    assert winners == {0, 1}


@pytest.mark.rule("R5.10", "R5.7")
def test_r5_10_a_refused_kill_is_told_to_those_who_were_enough(arbiter: Arbiter) -> None:
    """The winner gets KILL_FAILED and its partner LOST_CONTEST; a hunter alone waits."""
    case: dict[str, Any] = {
        "hunters": [(0.1, 0.0), (0.2, 0.0), (0.05, 0.0)],
        "targets": {"a": (0.0, 0.0)},
        "requests": [(0, "a"), (1, "a"), (2, "a")],
        "teams": [(0, 1), (2,)],
        "hunters_per_catch": 2,
        "kill_refused": ["a"],
    }
    expected = [(Verdict.KILL_FAILED, 0), (LOST, 0), (WAITS, None)]
    assert [(one.verdict, one.winner) for one in arbiter(**case)] == expected


@pytest.mark.rule("R5.10")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"hunters_per_catch": 2}, "hunters_per_catch must be 1 unless teams are given, got 2"),
        (
            {"hunters_per_catch": 3, "teams": [(0, 1)]},
            r"hunters_per_catch must be a whole number from 1 to 2 \(the size of the largest team\), got 3",
        ),
        ({"hunters_per_catch": 0, "teams": [(0, 1)]}, "hunters_per_catch must be a whole number from 1 to 64, got 0"),
        ({"hunters_per_catch": 1.5, "teams": [(0, 1)]}, "from 1 to 64, got 1.5"),
        (
            {"hunters_per_catch": 2, "teams": [(0, 1)], "policy": "capstone"},
            "hunters_per_catch must be 1 under the policy 'capstone', got 2",
        ),
        ({"teams": [(0,)]}, "teams must name each seat from 0 to 1 once, and each team"),
        ({"teams": "01"}, "teams must be a tuple of tuples of seats"),
    ],
)
def test_r5_10_arbitrate_refuses_what_no_team_can_do(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=f"^.*{message}"):
        arbitrate(hunters=[(0.0, 0.0), (1.0, 0.0)], targets={}, requests=[], **arguments)


# ---- arbitrate by itself ----


def test_arbitrate_takes_requests_and_targets_of_any_number() -> None:
    """None at all, and more than an arena can hold."""
    assert arbitrate(hunters=[], targets={}, requests=[]) == []
    assert arbitrate(hunters=[(0.0, 0.0)], targets={}, requests=[]) == []
    many = {f"t{i}": (float(i), 0.0) for i in range(200)}
    rulings = arbitrate(
        hunters=[(float(i), 0.0) for i in range(200)], targets=many, requests=[(i, f"t{i}") for i in range(200)]
    )
    assert verdicts(rulings) == [Verdict.GRANTED] * 200


def test_arbitrate_and_the_oracle_agree_on_random_cases() -> None:
    """Grids of a few micrometres, where ties abound, with every circumstance; seed 2026."""
    source = np.random.default_rng(2026)
    met: set[Verdict] = set()
    for case_number in range(400):
        count = int(source.integers(1, 7))
        names = [f"t{i}" for i in range(int(source.integers(0, 5)))]
        grid = float(source.choice([1e-6, 0.1, 0.15]))
        case: dict[str, Any] = {
            "hunters": [tuple((grid * source.integers(-2, 3, 2)).tolist()) for _ in range(count)],
            "targets": {name: tuple((grid * source.integers(-2, 3, 2)).tolist()) for name in names},
            "requests": [
                (int(source.integers(count)), [*names, "gone", "nobody", 5][int(source.integers(len(names) + 3))])
                for _ in range(int(source.integers(0, 9)))
            ],
            "reach_m": float(source.choice([0.3, 0.2, 3e-6])),
            "policy": str(source.choice(["nearest", "nearest", "first_come", "capstone"])),
            "seed": int(source.integers(2**63)),
            "step": int(source.integers(600)),
            "caught": ["gone"],
            "inactive": [seat for seat in range(count) if source.random() < 0.1],
            "kill_service_up": bool(source.random() < 0.9),
            "kill_refused": [name for name in names if source.random() < 0.2],
            "match_over": bool(source.random() < 0.03),
        }
        if case["policy"] != "capstone":
            case |= {"teams": [range(count)[::2], *(range(count)[1::2] and [range(count)[1::2]])]}
            case["hunters_per_catch"] = int(source.integers(1, min(2, (count + 1) // 2) + 1))
        found = arbitrate(**case)
        assert found == oracle_arbiter(**case), f"case {case_number}: {case}"
        met |= set(verdicts(found))
    assert met == set(Verdict)
