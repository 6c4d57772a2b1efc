"""Chapter 5: the arbiter. In the arena by rank; by name through `arbitrate` and the oracle's `judge`."""

import itertools
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oracle.arithmetic import KILL_REFUSED, SERVICE_LOT, TIE_LOT, draw, fraction, key
from rulebook.conftest import Arbiter, ArenaFactory, oracle_arbiter

from catch_arena.arbitration import arbitrate
from catch_arena.config import ArenaConfig
from catch_arena.core.state import TRUNCATED
from catch_arena.engine import Engine
from catch_arena.errors import ActionError, CatchArenaError, ConfigError, EpisodeError
from catch_arena.verdicts import Ruling, Verdict

STILL = (0.0, 0.0)


def verdicts(rulings: list[Ruling]) -> list[Verdict]:
    return [ruling.verdict for ruling in rulings]


# ---- R5.1 ----


@pytest.mark.rule("R5.1")
def test_r5_1_the_order_of_different_hunters_requests_does_not_matter(arbiter: Arbiter) -> None:
    """All 120 orders of five hunters' requests, over exact ties, contests and refusals."""
    case = {
        "hunters": [(1.0, 1.0), (1.2, 1.0), (1.4, 1.0), (5.0, 5.0), (1.1, 1.0)],
        "targets": {"a": (1.1, 1.0), "b": (1.3, 1.0)},
        "seed": 5,
        "step": 3,
    }
    requests = [(0, "a"), (1, "a"), (2, "b"), (3, "b"), (4, "a")]
    expected = {ruling.hunter: ruling for ruling in arbiter(**case, requests=requests)}
    assert len(set(verdicts(list(expected.values())))) > 2
    for order in itertools.permutations(requests):
        rulings = arbiter(**case, requests=order)
        assert [ruling.hunter for ruling in rulings] == [seat for seat, _ in order]
        assert {ruling.hunter: ruling for ruling in rulings} == expected


@pytest.mark.rule("R5.1")
def test_r5_1_no_grant_changes_another_requests_eligibility(arbiter: Arbiter) -> None:
    """Two targets at one place: each hunter asks for one, and neither catch takes anything from the other."""
    rulings = arbiter(
        hunters=[(1.0, 1.0), (1.0, 1.0)],
        targets={"a": (1.0, 1.0), "b": (1.0, 1.0)},
        requests=[(0, "b"), (1, "a")],
    )
    assert verdicts(rulings) == [Verdict.GRANTED] * 2


@pytest.mark.rule("R5.1")
def test_r5_1_relabelling_the_seats_relabels_the_verdicts(arbiter: Arbiter) -> None:
    """Without a tie: who sits where makes no difference."""
    places = [(1.0, 1.0), (1.25, 1.0), (1.05, 1.1), (2.0, 2.0)]
    targets = {"a": (1.1, 1.0), "b": (1.2, 1.1)}
    wanted = ["a", "a", "b", "b"]
    plain = arbiter(hunters=places, targets=targets, requests=list(enumerate(wanted)))
    for order in itertools.permutations(range(4)):
        seated = arbiter(
            hunters=[places[old] for old in order],
            targets=targets,
            requests=[(new, wanted[old]) for new, old in enumerate(order)],
        )
        for new, old in enumerate(order):
            assert seated[new].verdict is plain[old].verdict
            assert seated[new].distance_um == plain[old].distance_um
            winner = plain[old].winner
            assert seated[new].winner == (None if winner is None else order.index(winner))


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
@pytest.mark.parametrize(
    ("verdict", "requests", "circumstances"),
    [
        (Verdict.MATCH_OVER, [(0, "a")], {"match_over": True}),
        (Verdict.MALFORMED, [(0, 7)], {}),
        (Verdict.HUNTER_INACTIVE, [(0, "a")], {"inactive": [0]}),
        (Verdict.DUPLICATE, [(0, "far"), (0, "a")], {}),
        (Verdict.UNKNOWN_TARGET, [(0, "nobody")], {}),
        (Verdict.ALREADY_CAUGHT, [(0, "b")], {"caught": ["b"]}),
        (Verdict.SERVICE_DOWN, [(0, "a")], {"kill_service_up": False}),
        (Verdict.OUT_OF_REACH, [(0, "far")], {}),
        (Verdict.LOST_CONTEST, [(0, "a"), (1, "a")], {}),
        (Verdict.KILL_FAILED, [(0, "a")], {"kill_refused": ["a"]}),
        (Verdict.GRANTED, [(0, "a")], {}),
    ],
)
def test_r5_2_every_verdict_can_be_had(
    arbiter: Arbiter, verdict: Verdict, requests: list[tuple[int, Any]], circumstances: dict[str, Any]
) -> None:
    """Each of the eleven once, and success is true for GRANTED alone."""
    rulings = arbiter(**CALM, requests=requests, **circumstances)
    last = rulings[-1]
    assert last.verdict is verdict
    assert (last.hunter, last.target) == requests[-1]
    assert last.success == (verdict is Verdict.GRANTED)
    assert len(rulings) == len(requests)


@pytest.mark.rule("R5.2")
def test_r5_2_the_first_test_that_fails_names_the_verdict(arbiter: Arbiter) -> None:
    """A request that fails every test, with the reasons taken away one by one."""
    obstacles: list[tuple[Verdict, dict[str, Any]]] = [
        (Verdict.MATCH_OVER, {"match_over": True}),
        (Verdict.HUNTER_INACTIVE, {"inactive": (1,)}),
        (Verdict.SERVICE_DOWN, {"kill_service_up": False}),
        (Verdict.OUT_OF_REACH, {"reach_m": 0.05}),
        (Verdict.LOST_CONTEST, {"hunters": [(1.0, 1.0), (1.1, 1.0)]}),
        (Verdict.KILL_FAILED, {"kill_refused": ("a",)}),
    ]
    for left in range(len(obstacles) + 1):
        case: dict[str, Any] = {"hunters": [(1.2, 1.0), (1.1, 1.0)], "targets": {"a": (1.0, 1.0)}}
        for _, circumstance in obstacles[left:]:
            case |= circumstance
        expected = obstacles[left][0] if left < len(obstacles) else Verdict.GRANTED
        assert arbiter(**case, requests=[(0, "a"), (1, "a")])[1].verdict is expected


@pytest.mark.rule("R5.2")
def test_r5_2_malformed_goes_before_inactive_and_the_names_tests_before_the_services(arbiter: Arbiter) -> None:
    """Pairs of reasons, each of which would do alone."""
    down = {"kill_service_up": False}
    assert verdicts(arbiter(**CALM, requests=[(0, None)], match_over=True)) == [Verdict.MATCH_OVER]
    assert verdicts(arbiter(**CALM, requests=[(0, None)], inactive=[0])) == [Verdict.MALFORMED]
    assert verdicts(arbiter(**CALM, requests=[(0, "a"), (0, "a")], inactive=[0])) == [Verdict.HUNTER_INACTIVE] * 2
    assert verdicts(arbiter(**CALM, requests=[(0, "nobody"), (0, "nobody")]))[1] is Verdict.DUPLICATE
    assert verdicts(arbiter(**CALM, requests=[(0, "nobody")], **down)) == [Verdict.UNKNOWN_TARGET]
    assert verdicts(arbiter(**CALM, requests=[(0, "b")], caught=["b"], **down)) == [Verdict.ALREADY_CAUGHT]
    assert verdicts(arbiter(**CALM, requests=[(0, "far")], **down)) == [Verdict.SERVICE_DOWN]


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


@pytest.mark.rule("R5.2")
def test_r5_2_a_hunters_first_request_stands_whatever_its_verdict(arbiter: Arbiter) -> None:
    """The second is DUPLICATE, even if the first was refused; a malformed second one is MALFORMED."""
    rulings = arbiter(**CALM, requests=[(0, "far"), (1, "a"), (0, "a"), (0, 3), (1, "a")])
    assert verdicts(rulings) == [
        Verdict.OUT_OF_REACH,
        Verdict.GRANTED,
        Verdict.DUPLICATE,
        Verdict.MALFORMED,
        Verdict.DUPLICATE,
    ]
    assert rulings[2].distance_um is rulings[2].winner is None


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
    Verdict.LOST_CONTEST: {"earlier": [(0, "a")]},
    Verdict.KILL_FAILED: {"kill_refused": ["a"]},
    Verdict.GRANTED: {},
}
"""What must be so that hunter 1, 0.1 m from the target, gets each verdict when it asks."""


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
    """Of two reasons, each of which would do alone, the first in the table names the verdict."""

    def verdict_for(*reasons: Verdict) -> Verdict:
        case: dict[str, Any] = {"name": "a", "earlier": []}
        for reason in reasons:
            against = REASONS_AGAINST[reason]
            case |= against | {"earlier": [*case["earlier"], *against.get("earlier", [])]}
        requests = [*case.pop("earlier"), (1, case.pop("name"))]
        near = {"hunters": [(1.0, 1.05), (1.0, 1.1)], "targets": {"a": (1.0, 1.0), "b": (1.0, 1.2)}}
        return arbiter(**near, caught=["gone"], requests=requests, **case)[-1].verdict

    assert verdict_for(later) is later
    assert verdict_for(earlier) is earlier
    assert verdict_for(earlier, later) is earlier
    assert verdict_for(later, earlier) is earlier


@pytest.mark.rule("R5.2")
def test_r5_2_the_verdicts_are_numbered_in_the_order_of_the_table() -> None:
    """From 1, all eleven."""
    assert [(verdict.name, verdict.value) for verdict in Verdict] == [
        (name.name, number) for number, name in enumerate(ORDER, start=1)
    ]
    assert len(ORDER) == 11


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


@pytest.mark.rule("R5.2")
@pytest.mark.parametrize(
    ("control", "action"),
    [
        ("target", 9),
        ("target", -1),
        ("target", 1.5),
        ("target", "1"),
        ("target", None),
        ("target", True),
        ("velocity", [0.0]),
        ("velocity", [0.0, math.nan]),
        ("velocity", [-math.inf, 0.0]),
        ("velocity", 0.5),
        ("velocity", [[0.0, 0.0]]),
        ("velocity", ["a", "b"]),
        ("full", 1),
        ("full", {"cmd_vel": [0.0, 0.0]}),
        ("full", {"cmd_vel": [0.0, 0.0], "catch": 9}),
        ("full", {"cmd_vel": [0.0, math.inf], "catch": 1}),
        ("full", {"cmd_vel": [0.0, 0.0], "catch": 1, "kill": 1}),
    ],
)
def test_r5_2_what_lies_outside_the_action_space_is_an_error_and_nothing_moves(control: str, action: object) -> None:
    """Also where another hunter's action was fine; the message names the hunter."""
    from catch_arena.envs.parallel import parallel_env

    env = parallel_env("standard", hunters=2, control=("velocity", control))
    env.reset(seed=1)
    before = env.digest()
    with pytest.raises(ActionError, match="hunter_1"):
        env.step({"hunter_0": np.array([1.0, 1.0], np.float32), "hunter_1": action})
    assert env.digest() == before


@pytest.mark.rule("R5.2")
@pytest.mark.parametrize("control", ["velocity", "full"])
def test_r5_2_finite_velocities_are_clipped_to_the_action_space(control: str) -> None:
    """So that a policy whose actions have no bounds plays."""
    from catch_arena.envs.parallel import parallel_env

    digests = set()
    for pair in ([1.0, -1.0], [1.01, -2.0]):
        env = parallel_env("standard", hunters=1, control=control)
        env.reset(seed=1)
        env.step({"hunter_0": pair if control == "velocity" else {"cmd_vel": pair, "catch": 0}})
        digests.add(env.digest())
    assert len(digests) == 1


@pytest.mark.rule("R5.2")
def test_r5_2_after_the_end_there_is_no_step() -> None:
    """MATCH_OVER answers requests by name; an env's step after the end is an error."""
    from catch_arena.envs.parallel import parallel_env

    env = parallel_env("standard", hunters=1, max_cycles=1)
    env.reset(seed=1)
    env.step({"hunter_0": 0})
    before = env.digest()
    with pytest.raises(EpisodeError):
        env.step({"hunter_0": 0})
    assert env.digest() == before


@pytest.mark.rule("R5.2")
def test_r5_2_requests_after_the_end_are_match_over_and_nothing_changes() -> None:
    """In a batch the arenas that have ended wait for the others."""
    config = ArenaConfig(hunters=2, control="full", max_cycles=2, reach_m=50.0)
    engine = Engine(config)
    engine.reset([1])
    choices, commands = np.array([[1, 9]]), np.ones((1, 2, 2), np.float32)
    for _ in range(2):
        engine.step(choices, commands)
    assert engine.ends[0] == TRUNCATED
    before = engine.digest(0)
    engine.step(choices, commands)
    assert [ruling.verdict for ruling in engine.rulings(0)] == [Verdict.MATCH_OVER] * 2
    assert engine.digest(0) == before
    assert engine.ends[0] == TRUNCATED
    assert engine.rewards.tolist() == [[0.0, 0.0]]


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


@pytest.mark.rule("R5.4")
@pytest.mark.parametrize("nearest", range(4))
def test_r5_4_one_micrometre_decides_whatever_the_seat_and_the_seed(arbiter: Arbiter, nearest: int) -> None:
    """For twenty seeds each."""
    for seed in range(20):
        hunters = [(0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.0, -0.2)]
        x, y = hunters[nearest]
        hunters[nearest] = (x * 0.199999 / 0.2, y * 0.199999 / 0.2)
        requests = [(seat, "a") for seat in range(4)]
        rulings = arbiter(hunters=hunters, targets={"a": (0.0, 0.0)}, requests=requests, seed=seed)
        assert [ruling.success for ruling in rulings] == [seat == nearest for seat in range(4)]


@pytest.mark.rule("R5.4")
def test_r5_4_less_than_a_micrometre_does_not_decide(arbiter: Arbiter) -> None:
    """A quarter of one: the lot decides, so either hunter wins for some seed."""
    winners = {
        arbiter(
            hunters=[(0.2, 0.0), (-0.20000025, 0.0)],
            targets={"a": (0.0, 0.0)},
            requests=[(0, "a"), (1, "a")],
            seed=seed,
        )[0].winner
        for seed in range(20)
    }
    assert winners == {0, 1}


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


@pytest.mark.rule("R5.5")
def test_r5_5_losers_and_hunters_that_are_not_eligible_cannot_change_who_wins(arbiter: Arbiter) -> None:
    """Whatever the others of six hunters do, the winner between the two nearest is the same."""
    hunters = [(0.1, 0.0), (-0.1, 0.0), (0.2, 0.0), (0.0, 0.2), (5.0, 0.0), (0.0, 0.0)]
    for seed in range(8):
        case: dict[str, Any] = {"hunters": hunters, "targets": {"a": (0.0, 0.0)}, "seed": seed, "inactive": [5]}
        alone = arbiter(**case, requests=[(0, "a"), (1, "a")])[0].winner
        for count in range(1, 5):
            for others in itertools.combinations(range(2, 6), count):
                rulings = arbiter(**case, requests=[(0, "a"), (1, "a"), *((seat, "a") for seat in others)])
                assert rulings[0].winner == alone


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
    """And a winner only where there was a contest or a grant: not for one beyond the reach of a contested target."""
    case: dict[str, Any] = {"hunters": [(0.1, 0.0), (0.2, 0.0), (4.0, 0.0)], "targets": {"a": (0.0, 0.0)}}
    rulings = arbiter(**case, requests=[(0, "a"), (1, "a"), (2, "a"), (0, "a")])
    assert rulings[2] == Ruling(Verdict.OUT_OF_REACH, 2, "a", 4_000_000, None)
    assert rulings[3] == Ruling(Verdict.DUPLICATE, 0, "a", None, None)
    for circumstance in ({"match_over": True}, {"inactive": [0]}, {"kill_service_up": False}):
        (ruling,) = arbiter(**case, requests=[(0, "a")], **circumstance)
        assert ruling.distance_um is ruling.winner is None


@pytest.mark.rule("R5.6")
def test_r5_6_a_refused_kill_has_a_winner_only_where_it_was_contested(arbiter: Arbiter) -> None:
    """Alone there was neither contest nor grant."""
    case: dict[str, Any] = {
        "hunters": [(0.1, 0.0), (0.2, 0.0)],
        "targets": {"a": (0.0, 0.0)},
        "kill_refused": ["a"],
    }
    assert arbiter(**case, requests=[(0, "a")]) == [Ruling(Verdict.KILL_FAILED, 0, "a", 100_000, None)]
    assert arbiter(**case, requests=[(0, "a"), (1, "a")]) == [
        Ruling(Verdict.KILL_FAILED, 0, "a", 100_000, 0),
        Ruling(Verdict.LOST_CONTEST, 1, "a", 200_000, 0),
    ]


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


@pytest.mark.rule("R5.7")
def test_r5_7_the_refusal_is_drawn_for_each_step_and_target(arena: ArenaFactory) -> None:
    """At one half: the catch succeeds in the first step whose draw allows it."""
    outcomes = []
    for seed in range(12):
        match = arena(control="full", faults={"kill_refused": 0.5}, seed=seed)
        match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(9.0, 9.0), (5.0, 5.0)])
        for step in range(8):
            refused = fraction(draw(draw(key(seed, KILL_REFUSED), step), 2)) < 0.5
            match.step((STILL, 1))
            assert match.verdicts == [Verdict.KILL_FAILED if refused else Verdict.GRANTED]
            outcomes.append(refused)
            if not refused:
                break
    assert set(outcomes) == {True, False}


@pytest.mark.rule("R5.7")
def test_r5_7_a_refusal_by_name_concerns_that_target_alone(arbiter: Arbiter) -> None:
    """Another target of the same step is granted."""
    rulings = arbiter(
        hunters=[(0.0, 0.0), (1.0, 0.0)],
        targets={"a": (0.0, 0.0), "b": (1.0, 0.0)},
        requests=[(0, "a"), (1, "b")],
        kill_refused=["a"],
    )
    assert verdicts(rulings) == [Verdict.KILL_FAILED, Verdict.GRANTED]


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


@pytest.mark.rule("R5.8")
def test_r5_8_one_step_grants_a_target_once(arbiter: Arbiter) -> None:
    """However many ask for it."""
    rulings = arbiter(hunters=[(0.0, 0.0)] * 9, targets={"a": (0.0, 0.0)}, requests=[(seat, "a") for seat in range(9)])
    assert verdicts(rulings).count(Verdict.GRANTED) == 1
    assert verdicts(rulings).count(Verdict.LOST_CONTEST) == 8


@pytest.mark.rule("R5.8")
def test_r5_8_what_was_caught_earlier_is_already_caught(arbiter: Arbiter) -> None:
    """By name; it can never be credited again."""
    (ruling,) = arbiter(hunters=[(0.0, 0.0)], targets={}, requests=[(0, "a")], caught={"a"})
    assert ruling == Ruling(Verdict.ALREADY_CAUGHT, 0, "a", None, None)


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


@pytest.mark.rule("R5.9")
def test_r5_9_the_policy_is_part_of_the_config_and_has_three_names() -> None:
    """Nearest where nothing is said; another word is refused."""
    assert ArenaConfig().policy == "nearest"
    for policy in ("nearest", "first_come", "capstone"):
        assert ArenaConfig.from_dict(ArenaConfig(policy=policy).to_dict()).policy == policy
    with pytest.raises(ConfigError, match="policy"):
        ArenaConfig(policy="farthest")  # type: ignore[arg-type]


# ---- arbitrate by itself ----


def test_arbitrate_refuses_a_seat_that_does_not_exist() -> None:
    """Below, above, and what is no whole number; also among the inactive."""
    for seat in (2, -1, 0.5, "0", None, True):
        with pytest.raises(ActionError):
            arbitrate(**CALM, requests=[(seat, "a")])  # type: ignore[list-item]
    with pytest.raises(CatchArenaError):
        arbitrate(**CALM, requests=[], inactive=[2])


@pytest.mark.parametrize("place", [(math.nan, 0.0), (0.0, math.inf), (1.0,), (1.0, 2.0, 3.0), "xy", None, ("a", "b")])
def test_arbitrate_refuses_a_position_that_is_not_two_finite_numbers(place: Any) -> None:
    """A hunter's and a target's."""
    with pytest.raises(ActionError):
        arbitrate(hunters=[place], targets={"a": (0.0, 0.0)}, requests=[(0, "a")])
    with pytest.raises(ActionError):
        arbitrate(hunters=[(0.0, 0.0)], targets={"a": place}, requests=[(0, "a")])


@pytest.mark.parametrize(
    "setting",
    [
        {"reach_m": 0.0},
        {"reach_m": -1.0},
        {"reach_m": math.nan},
        {"policy": "farthest"},
        {"targets": [("a", (1.0, 1.0))]},
        {"targets": {1: (1.0, 1.0)}},
        {"caught": "a"},
        {"kill_refused": "a"},
        {"kill_refused": [1]},
        {"seed": -1},
        {"seed": 2**64},
        {"seed": 1.5},
        {"step": -1},
        {"step": None},
    ],
)
def test_arbitrate_refuses_settings_that_cannot_be(setting: dict[str, Any]) -> None:
    """The error names the argument."""
    (name,) = setting
    with pytest.raises(ConfigError, match=name):
        arbitrate(**{**CALM, "requests": [(0, "a")], **setting})


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
        found = arbitrate(**case)
        assert found == oracle_arbiter(**case), f"case {case_number}: {case}"
        met |= set(verdicts(found))
    assert met == set(Verdict)
