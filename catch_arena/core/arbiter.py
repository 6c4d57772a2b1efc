"""Rulebook chapter 5: decisions on catch requests.

The arbiter judges a *request table*: one row for each request of one step in one arena, in the columns below. It reads
distances and eligibility from there alone, so nothing that it grants can change another request (R5.1). The engine
and `catch_arena.arbitrate` fill the table; the same code judges both. It ignores teams, except that it counts the
hunters of one team (R5.10): team-mates contest a target like all other hunters (R11.3).
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core import rows
from catch_arena.core.addresses import by_address
from catch_arena.core.jit import entry, outlined, phase, rule
from catch_arena.core.random import service_lot, tie_lot
from catch_arena.core.vectors import floor, sqrt
from catch_arena.verdicts import Verdict

RequestTable = NDArray[np.int64]
"""Table of requests, (requests, REQUEST_COLUMNS)."""

REQUEST_SEAT: Final = 0  # the hunter's seat, from 0
REQUEST_TARGET: Final = 1  # requested target: any number that differs by target, or a code of core/rows.py
REQUEST_NUMBER: Final = 2  # the target's spawn number, for the lot
REQUEST_DISTANCE: Final = 3  # to the target [micrometres], from 0; NOT_MEASURED if reach is not tested
REQUEST_INACTIVE: Final = 4  # flag: the hunter is withdrawn
REQUEST_KILL_REFUSED: Final = 5  # flag: the simulator would refuse this kill
REQUEST_REACH: Final = 6  # reach of the hunter [micrometres], above 0
REQUEST_TEAM: Final = 7  # any number that differs by team
REQUEST_VERDICT: Final = 8  # output: a number of Verdict
REQUEST_WINNER: Final = 9  # output: a seat, or NO_SEAT
REQUEST_COLUMNS: Final = 10

NEAREST: Final = 0
FIRST_COME: Final = 1
CAPSTONE: Final = 2
POLICIES: Final = {"nearest": NEAREST, "first_come": FIRST_COME, "capstone": CAPSTONE}

ELIGIBLE: Final = -1
"""Value in place of a verdict: no test of R5.2 fails. NO_REQUEST is 0."""
_MAY_CATCH: Final = (ELIGIBLE, int(Verdict.WAITING_FOR_PARTNER))
"""R5.10: verdicts of requests that fail no test alone, before contests are decided."""
_REACH_TESTED: Final = (ELIGIBLE, int(Verdict.OUT_OF_REACH))
"""R5.6: verdicts of requests whose reach was tested, before contests are decided."""


@rule
def to_micrometres(metres: float) -> float:
    """R5.3: return a length in whole micrometres."""
    return floor(1000000.0 * metres + 0.5)


@rule
def measure_um(dx: float, dy: float) -> float:
    """R5.3: return the distance between two centres in whole micrometres."""
    return to_micrometres(sqrt(dx * dx + dy * dy))


@rule
def within_reach(distance_um: float, reach_um: float) -> bool:
    """R5.3: return whether a distance is strictly less than reach."""
    return distance_um < reach_um


@rule
def first_failed_test(
    policy: int,
    target: int,
    distance_um: float,
    reach_um: float,
    inactive: bool,
    duplicate: bool,
    over: bool,
    service_up: bool,
) -> int:
    """R5.2: return the first test that a request fails regardless of other hunters, or ELIGIBLE if it fails none.

    R9.1: the policy CAPSTONE is the original's service, which grants every request that it can answer at all.

    `controllers.look_up_choices` finds ranks without a target; `judge` finds duplicates.
    `target` is the requested slot or number, or a code: MALFORMED_REQUEST, NEVER_SPAWNED, ALREADY_GONE.
    """
    if over:
        return Verdict.MATCH_OVER
    if target == rows.MALFORMED_REQUEST:
        return Verdict.MALFORMED
    if inactive:
        return Verdict.HUNTER_INACTIVE
    if policy == CAPSTONE:
        return Verdict.GRANTED if service_up else Verdict.SERVICE_DOWN
    if duplicate:
        return Verdict.DUPLICATE
    if target == rows.NEVER_SPAWNED:
        return Verdict.UNKNOWN_TARGET
    if target == rows.ALREADY_GONE:
        return Verdict.ALREADY_CAUGHT
    if not service_up:
        return Verdict.SERVICE_DOWN
    return ELIGIBLE if within_reach(distance_um, reach_um) else Verdict.OUT_OF_REACH


@rule
def is_preferred(
    policy: int,
    seed: np.uint64,
    step: int,
    number: int,
    seat: int,
    distance_um: int,
    rival_seat: int,
    rival_distance_um: int,
) -> bool:
    """R5.4, R5.5, R5.9: return whether a seat is preferred to a rival for the target that both may catch."""
    if policy == FIRST_COME:
        mine = service_lot(seed, step, seat)
        other = service_lot(seed, step, rival_seat)
    else:
        if distance_um != rival_distance_um:
            return distance_um < rival_distance_um
        mine = tie_lot(seed, step, number, seat)
        other = tie_lot(seed, step, number, rival_seat)
    return bool(mine < other)  # lots of two seats are never equal: A.5's mix is a permutation


@phase
def judge(
    requests: RequestTable,
    policy: int,
    seed: np.uint64,
    step: int,
    over: bool,
    service_up: bool,
    partners_needed: int,
) -> None:
    """R5.1 to R5.10: write the verdict and the winner of every request of one step. First come R5.2's tests, which a
    request fails alone, then R5.10's partners, and then the contests among the other requests.

    Args:
        requests: the request table; REQUEST_VERDICT and REQUEST_WINNER are written, and REQUEST_DISTANCE becomes
            NOT_MEASURED if reach was not tested.
        policy: NEAREST, FIRST_COME or CAPSTONE (R5.9, R9.1).
        partners_needed: number of partners that a catch needs, hunters_per_catch - 1 (R5.10).
    """
    for i in range(len(requests)):
        duplicate = False
        for j in range(i):
            duplicate = duplicate or requests[j, REQUEST_SEAT] == requests[i, REQUEST_SEAT]
        inactive = requests[i, REQUEST_INACTIVE] != 0
        verdict = first_failed_test(
            policy,
            requests[i, REQUEST_TARGET],
            requests[i, REQUEST_DISTANCE],
            requests[i, REQUEST_REACH],
            inactive,
            duplicate,
            over,
            service_up,
        )
        requests[i, REQUEST_VERDICT] = verdict
        requests[i, REQUEST_WINNER] = requests[i, REQUEST_SEAT] if verdict == Verdict.GRANTED else rows.NO_SEAT
        if verdict not in _REACH_TESTED:
            requests[i, REQUEST_DISTANCE] = rows.NOT_MEASURED  # R5.6
    if partners_needed > 0:
        refuse_without_partners(requests, partners_needed)
    for i in range(len(requests)):
        if requests[i, REQUEST_VERDICT] == ELIGIBLE:
            decide_contest(requests, i, policy, seed, step)


@outlined
def refuse_without_partners(requests: RequestTable, partners_needed: int) -> None:
    """R5.10: refuse the requests in which too few hunters of one team may catch the same target. Requests
    that fail no earlier test have the verdict ELIGIBLE so far.
    """
    for i in range(len(requests)):
        if requests[i, REQUEST_VERDICT] == ELIGIBLE:
            partners = -1  # the hunter itself is counted too
            for j in range(len(requests)):
                if (
                    requests[j, REQUEST_VERDICT] in _MAY_CATCH
                    and requests[j, REQUEST_TARGET] == requests[i, REQUEST_TARGET]
                    and requests[j, REQUEST_TEAM] == requests[i, REQUEST_TEAM]
                ):
                    partners += 1
            if partners < partners_needed:
                requests[i, REQUEST_VERDICT] = Verdict.WAITING_FOR_PARTNER


@outlined
def decide_contest(requests: RequestTable, one: int, policy: int, seed: np.uint64, step: int) -> None:
    """R5.4 to R5.7: write the verdicts of all requests in one contest, those that may catch the same target. They have
    the verdict ELIGIBLE so far; `one` is the first row among them.
    """
    target = requests[one, REQUEST_TARGET]
    best = one
    claimants = 0
    for i in range(len(requests)):
        if requests[i, REQUEST_VERDICT] == ELIGIBLE and requests[i, REQUEST_TARGET] == target:
            claimants += 1
            if i != best and is_preferred(
                policy,
                seed,
                step,
                requests[i, REQUEST_NUMBER],
                requests[i, REQUEST_SEAT],
                requests[i, REQUEST_DISTANCE],
                requests[best, REQUEST_SEAT],
                requests[best, REQUEST_DISTANCE],
            ):
                best = i
    for i in range(len(requests)):
        if requests[i, REQUEST_VERDICT] == ELIGIBLE and requests[i, REQUEST_TARGET] == target:
            requests[i, REQUEST_VERDICT] = Verdict.LOST_CONTEST
            requests[i, REQUEST_WINNER] = requests[best, REQUEST_SEAT]
    refused = requests[best, REQUEST_KILL_REFUSED] != 0
    requests[best, REQUEST_VERDICT] = Verdict.KILL_FAILED if refused else Verdict.GRANTED
    if refused and claimants == 1:
        requests[best, REQUEST_WINNER] = rows.NO_SEAT  # R5.6: neither a grant nor a contest


@entry
def judge_alone(
    requests: RequestTable,
    policy: int,
    seed: np.uint64,
    step: int,
    over: bool,
    service_up: bool,
    partners_needed: int,
) -> None:
    """Judge a request table without an arena: see `judge`."""
    judge(by_address(requests), policy, seed, step, over, service_up, partners_needed)
