"""Rulebook R1.4's phases 3 and 4: the requests of a step become dockets, are judged (core/arbiter.py), and what was
granted is done.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.arbiter import (
    DISTANCE,
    INACTIVE,
    NO_SUCH_RANK,
    REFUSED,
    SEAT,
    TARGET,
    TARGET_NUMBER,
    Docket,
    distance_um,
    judge,
)
from catch_arena.core.arbiter import VERDICT as DOCKET_VERDICT
from catch_arena.core.arbiter import WINNER as DOCKET_WINNER
from catch_arena.core.jit import Block, passage, phase
from catch_arena.core.random import kill_refused, kill_service_down, seed_of
from catch_arena.core.rewards import aim_again
from catch_arena.core.spawner import remove_target
from catch_arena.core.state import (
    ALIVE,
    CONTESTS_WON,
    DISTANCE_UM,
    ENDED,
    EVIDENCE,
    LANES,
    NO_TARGET,
    REQUEST,
    RUNNING,
    SCORE,
    SEED_HIGH,
    SEED_LOW,
    STEP,
    TALLIES,
    VERDICT,
    WANTED,
    WINNER,
    WITHDRAWN,
    Settings,
    Targets,
    X,
    Y,
    seat_of,
    span,
)
from catch_arena.core.vectors import Width, any_of, group, select
from catch_arena.core.workspace import Scratch, aim_of
from catch_arena.verdicts import Verdict

_GRANTED: Final = int(Verdict.GRANTED)
_LOST_CONTEST: Final = int(Verdict.LOST_CONTEST)


@passage
def clear_evidence(block: Block, s: Settings, width: Width, asked: Block) -> None:
    """No verdict yet; `asked` counts the wishes of each lane."""
    for first in range(0, span(width), len(width)):
        lane = group(first, width)
        wishes = 0.0
        judged = False
        for seat in range(s.hunters):
            me = seat_of(block, seat)
            wishes = wishes + select(me[WANTED + lane] == float(NO_TARGET), 0.0, 1.0)
            judged = judged | (me[VERDICT + lane] > 0.0)
        asked[lane] = wishes
        if any_of(judged):  # most steps leave nothing to be cleared
            for seat in range(s.hunters):
                me = seat_of(block, seat)
                me[REQUEST + lane] = 0.0
                me[VERDICT + lane] = 0.0
                me[DISTANCE_UM + lane] = -1.0
                me[WINNER + lane] = -1.0


@passage
def arbitrate(block: Block, s: Settings, lane: int, targets: Targets, docket: Docket) -> None:
    """R1.4's phase 3 in one lane: the docket is filled from S_t, judged, and the evidence noted."""
    seed = seed_of(block[SEED_HIGH + lane], block[SEED_LOW + lane])
    step = block[STEP + lane]
    requests = 0
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        wanted = int(me[WANTED + lane])
        if wanted == NO_TARGET:
            continue
        docket[requests, SEAT] = seat
        docket[requests, TARGET] = wanted
        docket[requests, TARGET_NUMBER] = 0
        docket[requests, DISTANCE] = -1
        docket[requests, INACTIVE] = int(me[WITHDRAWN + lane])
        docket[requests, REFUSED] = 0
        if wanted != NO_SUCH_RANK:
            at = wanted * LANES + lane
            number = targets.number[at]
            me[REQUEST + lane] = number
            docket[requests, TARGET_NUMBER] = int(number)
            docket[requests, DISTANCE] = int(distance_um(targets.x[at] - me[X + lane], targets.y[at] - me[Y + lane]))
            docket[requests, REFUSED] = int(kill_refused(seed, step, number, s.kill_refused_rate))
        requests += 1
    service_up = not kill_service_down(seed, step, s.kill_down_rate)
    judge(docket[:requests], s.policy, seed, int(step), int(s.reach_um), block[ENDED + lane] != RUNNING, service_up)
    for i in range(requests):
        me = seat_of(block, docket[i, SEAT])
        me[VERDICT + lane] = docket[i, DOCKET_VERDICT]
        me[DISTANCE_UM + lane] = docket[i, DISTANCE]
        me[WINNER + lane] = docket[i, DOCKET_WINNER]
        me[TALLIES + (docket[i, DOCKET_VERDICT] - 1) * LANES + lane] += 1.0
        for j in range(requests):
            if docket[j, DOCKET_VERDICT] == _LOST_CONTEST and docket[j, DOCKET_WINNER] == docket[i, SEAT]:
                me[CONTESTS_WON + lane] += 1.0
                break


@passage
def commit(block: Block, s: Settings, lane: int, targets: Targets, scratch: Scratch) -> None:
    """R1.4's phase 4 in one lane: grants are credited, and the targets whose kill is not refused leave (R5.7, R5.8)."""
    seed = seed_of(block[SEED_HIGH + lane], block[SEED_LOW + lane])
    removed = 0
    for slot in range(int(block[ALIVE + lane]) - 1, -1, -1):  # backwards: those behind a removed slot move up
        number = targets.number[slot * LANES + lane]
        caught = False
        for seat in range(s.hunters):
            me = seat_of(block, seat)
            caught = caught or (me[VERDICT + lane] == _GRANTED and me[REQUEST + lane] == number)
        if caught and not kill_refused(seed, block[STEP + lane], number, s.kill_refused_rate):
            remove_target(block, targets, lane, slot)
            removed += 1
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        me[SCORE + lane] += 1.0 if me[VERDICT + lane] == _GRANTED else 0.0
    if removed > 0 and s.progress_wanted:
        for seat in range(s.hunters):
            aim_again(block, seat_of(block, seat), targets, lane, aim_of(scratch, seat))


@passage
def settle(block: Block, s: Settings, width: Width, lanes: int, targets: Targets, scratch: Scratch) -> None:
    """R1.4's phases 3 and 4 in every lane in which somebody asks for a target."""
    asked = scratch.rows[:LANES]
    clear_evidence(block, s, width, asked)
    for lane in range(lanes):
        if asked[lane] > 0.0:
            arbitrate(block, s, lane, targets, scratch.docket)
            commit(block, s, lane, targets, scratch)


@phase
def note_evidence(block: Block, s: Settings, lanes: int, evidence: NDArray[np.float64]) -> None:
    """R5.6: the answers to the requests of this step, for those who look from outside; (lanes, H, 4), or none."""
    for lane in range(min(lanes, len(evidence))):
        for seat in range(s.hunters):
            for column in range(len(EVIDENCE)):
                evidence[lane, seat, column] = seat_of(block, seat)[EVIDENCE[column] + lane]
