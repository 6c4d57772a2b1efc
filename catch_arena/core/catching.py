"""Rulebook R1.4's phases 3 and 4: judge the requests of a step (core/arbiter.py), and carry out the grants."""

from catch_arena.core import rows
from catch_arena.core.arbiter import (
    REQUEST_DISTANCE,
    REQUEST_INACTIVE,
    REQUEST_KILL_REFUSED,
    REQUEST_NUMBER,
    REQUEST_REACH,
    REQUEST_SEAT,
    REQUEST_TARGET,
    REQUEST_TEAM,
    REQUEST_VERDICT,
    REQUEST_WINNER,
    RequestTable,
    judge,
    measure_um,
)
from catch_arena.core.jit import Rows, phase
from catch_arena.core.memory import Sections
from catch_arena.core.prey import catch_prey
from catch_arena.core.random import kill_refused, kill_service_down, seed_of
from catch_arena.core.rewards import renew_references
from catch_arena.core.spawner import remove_target
from catch_arena.core.state import Settings, limits_of, seat_of
from catch_arena.core.vectors import LANES
from catch_arena.verdicts import NO_REQUEST, Verdict


@phase
def collect_requests(chunk: Rows, s: Settings, lane: int, sections: Sections, table: RequestTable) -> int:
    """Write the seats and slots of the hunters' requests in one lane into the last of a table's first H rows, in the
    order of seats, and return the first of these rows.

    `fill_requests` writes the other columns. The verdicts of the last step are cleared; without a verdict the evidence
    next to it is not read.
    """
    first = s.hunters
    for seat in range(s.hunters - 1, -1, -1):
        seat_of(chunk, seat)[rows.VERDICT + lane] = NO_REQUEST
        slot = sections.requested_slots[seat, lane]
        if slot != float(rows.NO_TARGET):
            first -= 1
            table[first, REQUEST_SEAT] = seat
            table[first, REQUEST_TARGET] = int(slot)
    return first


@phase
def fill_requests(
    chunk: Rows, s: Settings, lane: int, targets: Rows, requests: RequestTable, sections: Sections
) -> None:
    """Write the arbiter's facts about each request, as they are in S_t: the columns from REQUEST_NUMBER to
    REQUEST_TEAM. The table has the seats, and the slots or codes in their place.
    """
    seed = seed_of(chunk, lane)
    step = chunk[rows.STEP + lane]
    for i in range(len(requests)):
        seat = requests[i, REQUEST_SEAT]
        me = seat_of(chunk, seat)
        slot = requests[i, REQUEST_TARGET]
        requests[i, REQUEST_NUMBER] = 0
        requests[i, REQUEST_DISTANCE] = rows.NOT_MEASURED
        requests[i, REQUEST_REACH] = int(limits_of(sections.limits, seat).reach_um)
        requests[i, REQUEST_INACTIVE] = int(me[rows.WITHDRAWN + lane])
        requests[i, REQUEST_KILL_REFUSED] = 0
        requests[i, REQUEST_TEAM] = sections.teams[seat]
        if slot >= 0:
            at = slot * s.slot_size + lane
            number = targets[rows.NUMBER + at]
            requests[i, REQUEST_NUMBER] = int(number)
            requests[i, REQUEST_DISTANCE] = int(
                measure_um(
                    targets[rows.TARGET_X + at] - me[rows.X + lane], targets[rows.TARGET_Y + at] - me[rows.Y + lane]
                )
            )
            requests[i, REQUEST_KILL_REFUSED] = int(kill_refused(seed, step, number, s.kill_refused_rate))


@phase
def judge_requests(chunk: Rows, s: Settings, lane: int, requests: RequestTable) -> None:
    """R1.4's phase 3 in one lane: judge the request table, and keep the ruling on each hunter's first request."""
    seed, step = seed_of(chunk, lane), int(chunk[rows.STEP + lane])
    over = chunk[rows.ENDED + lane] != rows.RUNNING
    service_up = not kill_service_down(seed, step, s.kill_down_rate)
    judge(requests, s.policy, seed, step, over, service_up, s.partners_needed)
    for i in range(len(requests) - 1, -1, -1):  # backwards: a hunter's first request is written last
        me = seat_of(chunk, requests[i, REQUEST_SEAT])
        me[rows.REQUESTED_NUMBER + lane] = requests[i, REQUEST_NUMBER]
        me[rows.VERDICT + lane] = requests[i, REQUEST_VERDICT]
        me[rows.DISTANCE + lane] = requests[i, REQUEST_DISTANCE]
        me[rows.WINNER + lane] = requests[i, REQUEST_WINNER]
        me[rows.TALLIES + requests[i, REQUEST_VERDICT] * LANES + lane] += 1.0  # one row for each verdict
        if requests[i, REQUEST_WINNER] == requests[i, REQUEST_SEAT]:
            for j in range(len(requests)):
                same_target = requests[j, REQUEST_TARGET] == requests[i, REQUEST_TARGET]
                if same_target and requests[j, REQUEST_VERDICT] == Verdict.LOST_CONTEST:
                    me[rows.CONTESTS_WON + lane] += 1.0
                    break


@phase
def commit(chunk: Rows, s: Settings, lane: int, targets: Rows, requests: RequestTable, sections: Sections) -> None:
    """R1.4's phase 4 in one lane: credit the grants, and remove the targets whose kill is not refused (R5.7, R5.8).

    Under `capstone` a grant counts even if the kill is refused, and several hunters may have one for the same target.
    """
    for i in range(len(requests)):
        if requests[i, REQUEST_VERDICT] == Verdict.GRANTED:
            seat_of(chunk, requests[i, REQUEST_SEAT])[rows.SCORE + lane] += 1.0
    removed = 0
    for slot in range(int(chunk[rows.ALIVE + lane]) - 1, -1, -1):  # backwards: targets after a removed slot move up
        catcher = s.hunters  # no seat
        for i in range(len(requests)):
            granted = requests[i, REQUEST_VERDICT] == Verdict.GRANTED and requests[i, REQUEST_KILL_REFUSED] == 0
            if granted and requests[i, REQUEST_TARGET] == slot:
                catcher = min(catcher, requests[i, REQUEST_SEAT])  # of several, under `capstone`, the lowest
        if catcher != s.hunters:
            if s.prey > 0:
                catch_prey(chunk, s, lane, catcher, slot)
            remove_target(chunk, s, lane, targets, slot)
            removed += 1
    if removed > 0:
        renew_references(chunk, s, lane, targets, sections)


@phase
def resolve_requests(
    chunk: Rows, s: Settings, lanes: int, targets: Rows, given_requests: RequestTable, sections: Sections
) -> None:
    """R1.4's phases 3 and 4: judge the requests of this step, and carry out the grants, lane by lane.

    `given_requests` is empty, or a table of further requests in a chunk of one arena: their seats and slots, or the
    codes in place of slots, after H rows for the requests of the hunters' actions, which come first.
    """
    table = given_requests if len(given_requests) > 0 else sections.requests
    for lane in range(lanes):
        requests = table[collect_requests(chunk, s, lane, sections, table) :]
        if len(requests) > 0:
            fill_requests(chunk, s, lane, targets, requests, sections)
            judge_requests(chunk, s, lane, requests)
            commit(chunk, s, lane, targets, requests, sections)
