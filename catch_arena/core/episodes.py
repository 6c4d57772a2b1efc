"""How an episode begins, and what is kept of one that has ended."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.jit import Block, passage, rare
from catch_arena.core.math import PI, TAU, sincos, wrap
from catch_arena.core.observations import Observations
from catch_arena.core.random import START, draw, fraction, next_seed, seed_of, stream
from catch_arena.core.spawner import spawn_next
from catch_arena.core.state import (
    CONTESTS_WON,
    DISTANCE_UM,
    ENDED,
    LANES,
    NO_TARGET,
    RETURN,
    RUNNING,
    SCORE,
    SEED_HIGH,
    SEED_LOW,
    STEP,
    THETA,
    WANTED,
    WINNER,
    Settings,
    X,
    Y,
    seat_of,
    targets_of,
)
from catch_arena.verdicts import Verdict

# columns of a record: one hunter's episode in figures
LENGTH: Final = 0  # steps
FINAL_SCORE: Final = 1
FINAL_RANK: Final = 2  # R6.1: 1 + how many have more
FINAL_RETURN: Final = 3  # the rewards, summed
FINAL_CONTESTS_WON: Final = 4
FINAL_TALLIES: Final = 5  # how often each verdict was met, in the order of Verdict
RECORD_COLUMNS: Final = FINAL_TALLIES + len(Verdict)


@rare
def finish(block: Block, s: Settings, lane: int, record: NDArray[np.float64]) -> None:
    """An episode in figures, (H, RECORD_COLUMNS), as it stands in one lane."""
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        rank = 1.0
        for other in range(s.hunters):
            rank += 1.0 if seat_of(block, other)[SCORE + lane] > me[SCORE + lane] else 0.0
        record[seat, LENGTH] = block[STEP + lane]
        record[seat, FINAL_SCORE] = me[SCORE + lane]
        record[seat, FINAL_RANK] = rank
        record[seat, FINAL_RETURN] = me[RETURN + lane]
        for column in range(FINAL_CONTESTS_WON, RECORD_COLUMNS):
            record[seat, column] = me[CONTESTS_WON + (column - FINAL_CONTESTS_WON) * LANES + lane]


@rare
def begin(block: Block, s: Settings, lane: int, start_poses: Block, seed: np.uint64) -> None:
    """R2.6, R3.1, A.6: one arena at the beginning of an episode."""
    for row in range(len(block) // LANES):
        block[row * LANES + lane] = 0.0
    block[SEED_HIGH + lane] = float(seed >> np.uint64(32))
    block[SEED_LOW + lane] = float(seed & np.uint64(0xFFFFFFFF))
    turn = TAU * fraction(draw(stream(seed, START), np.uint64(0)))
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        if len(start_poses) > 0:
            me[X + lane] = start_poses[3 * seat]
            me[Y + lane] = start_poses[3 * seat + 1]
            me[THETA + lane] = wrap(start_poses[3 * seat + 2])
        elif s.hunters == 1:
            me[X + lane] = s.side / 2.0
            me[Y + lane] = s.side / 2.0
        else:
            angle = wrap(turn + TAU * seat / s.hunters)
            sine, cosine = sincos(angle)
            me[X + lane] = s.side / 2.0 + s.start_radius * cosine
            me[Y + lane] = s.side / 2.0 + s.start_radius * sine
            me[THETA + lane] = wrap(angle + PI)
        me[WANTED + lane] = NO_TARGET
        me[DISTANCE_UM + lane] = -1.0
        me[WINNER + lane] = -1.0
    targets = targets_of(block, s)
    for _ in range(s.initial_targets):
        spawn_next(block, targets, lane, seed, s, 0.0)


@passage
def begin_again(
    block: Block,
    s: Settings,
    lanes: int,
    start_poses: Block,
    observations: Observations,
    last_observations: Observations,
    records: NDArray[np.float64],
) -> None:
    """A.5: where an episode has just ended, its last observations and figures are kept, and the next one begins."""
    for lane in range(lanes):
        if block[ENDED + lane] == RUNNING:
            continue
        for seat in range(s.hunters):
            for column in range(observations.shape[2]):
                last_observations[lane, seat, column] = observations[lane, seat, column]
        finish(block, s, lane, records[lane])
        seed = seed_of(block[SEED_HIGH + lane], block[SEED_LOW + lane])
        begin(block, s, lane, start_poses, next_seed(seed))
