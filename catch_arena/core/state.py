"""The arena memory: everything that an arena is, as rows of float64 in blocks of LANES arenas.

A block is one flat, contiguous slice: row r of lane l lies at r * LANES + l. One arena is one column, and to save it
is to copy that column. The rows of a block: the arena's own, then HUNTER_ROWS for each seat, then TARGET_ROWS for
each slot, then K slots for each seat's view. Integers are exact in float64; a seed needs two of them. Alive targets
fill the slots from 0 in spawning order (R8.2), all others are zero.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.jit import Block, accessor, entry, rule

LANES: Final = 32
"""Arenas side by side in a block: enough for the widest SIMD registers, few enough for the first caches."""

# arena rows; the first eight stand in the digest in this order (A.8)
TIME: Final = 0 * LANES  # [ms] since reset
STEP: Final = 1 * LANES  # steps played
SPAWNED: Final = 2 * LANES  # targets that appeared
NUMBERS: Final = 3 * LANES  # numbers used up
FIRINGS: Final = 4 * LANES  # of the spawn timer
SKIPPED_FULL: Final = 5 * LANES  # R3.5
SKIPPED_DOWN: Final = 6 * LANES  # R3.6
REFUSED: Final = 7 * LANES  # R3.6
ARENA_DIGEST_ROWS: Final = 8
ALIVE: Final = 8 * LANES  # targets alive: slots in use
ENDED: Final = 9 * LANES  # RUNNING, TERMINATED or TRUNCATED (R1.5)
SEED_HIGH: Final = 10 * LANES  # the seed's upper 32 bits
SEED_LOW: Final = 11 * LANES  # and its lower 32
ARENA_ROWS: Final = 12

# hunter rows; the first eleven stand in the digest in this order (A.8)
X: Final = 0 * LANES  # [m]
Y: Final = 1 * LANES  # [m]
THETA: Final = 2 * LANES  # [rad] in [-pi, pi)
SPEED: Final = 3 * LANES  # [m/s]
TURN_RATE: Final = 4 * LANES  # [rad/s]
DISTANCE_INTEGRAL: Final = 5 * LANES  # [m s]
BEARING_INTEGRAL: Final = 6 * LANES  # [rad s]
ACTIVE: Final = 7 * LANES  # number of the active target, 0 for none
SCORE: Final = 8 * LANES  # granted catches
AT_WALL: Final = 9 * LANES  # R2.3's flag
WITHDRAWN: Final = 10 * LANES  # R1.6's flag
HUNTER_DIGEST_ROWS: Final = 11
SINE: Final = 11 * LANES  # of theta
COSINE: Final = 12 * LANES
SEEN: Final = 13 * LANES  # how many targets are in the view
WANTED: Final = 14 * LANES  # slot requested in this step, NO_TARGET or NO_SUCH_RANK
REQUEST: Final = 15 * LANES  # number of the target requested, 0 for none
VERDICT: Final = 16 * LANES  # R5.2, 0 for no request
DISTANCE_UM: Final = 17 * LANES  # the verdict's evidence [micrometres], -1 for none
WINNER: Final = 18 * LANES  # seat, -1 for none
NEAREST_X: Final = 19 * LANES  # the target nearest after the commit [m]
NEAREST_Y: Final = 20 * LANES
NEAREST_DISTANCE: Final = 21 * LANES  # before the motion [m], -1 for none
PARTS: Final = 22 * LANES  # R6.2's parts of the reward, in the order of PART_NAMES
PART_NAMES: Final = ("catch", "rival_catch", "lost_contest", "rejected_request", "progress", "time")
CATCH, RIVAL_CATCH, LOST, REJECTED, PROGRESS, ELAPSED = (PARTS + i * LANES for i in range(6))
HUNTER_ROWS: Final = 28
SEAT_SIZE: Final = HUNTER_ROWS * LANES

# rows of a target slot; all five stand in the digest in this order (A.8)
TARGET_ROWS: Final = 5

NO_TARGET: Final = -1

RUNNING: Final = 0.0
TERMINATED: Final = 1.0
TRUNCATED: Final = 2.0


class Targets(NamedTuple):
    """The slots of a block, one array a field: slot s of lane l lies at s * LANES + l."""

    number: Block
    x: Block
    y: Block
    theta: Block
    appeared: Block


class Settings(NamedTuple):
    """The config in SI units and as scalars, in the order in which `engine` writes them."""

    hunters: int
    slots: int
    targets_seen: int
    hunters_seen: int
    policy: int
    progress_wanted: int
    target_budget: float
    side: float
    reach_um: float
    max_speed: float
    min_speed: float
    max_turn_rate: float
    kp_v: float
    ki_v: float
    kp_w: float
    ki_w: float
    period: float
    period_s: float
    time_limit: float
    spawn_period: float
    spawn_low: float
    spawn_high: float
    spawn_last: float
    start_radius: float
    initial_targets: int
    kill_down_rate: float
    kill_refused_rate: float
    spawn_down_rate: float
    spawn_refused_rate: float
    catch_weight: float
    rival_catch_weight: float
    lost_contest_weight: float
    rejected_request_weight: float
    progress_weight: float
    time_weight: float


@rule
def read_settings(numbers: NDArray[np.float64]) -> Settings:
    """The settings from the array in which they reach compiled code: a tuple of scalars would cost microseconds a
    call to hand over.
    """
    return Settings(
        int(numbers[0]),
        int(numbers[1]),
        int(numbers[2]),
        int(numbers[3]),
        int(numbers[4]),
        int(numbers[5]),
        numbers[6],
        numbers[7],
        numbers[8],
        numbers[9],
        numbers[10],
        numbers[11],
        numbers[12],
        numbers[13],
        numbers[14],
        numbers[15],
        numbers[16],
        numbers[17],
        numbers[18],
        numbers[19],
        numbers[20],
        numbers[21],
        numbers[22],
        numbers[23],
        int(numbers[24]),
        numbers[25],
        numbers[26],
        numbers[27],
        numbers[28],
        numbers[29],
        numbers[30],
        numbers[31],
        numbers[32],
        numbers[33],
        numbers[34],
    )


@entry
def block_rows(hunters: int, slots: int, targets_seen: int) -> int:
    """How many rows a block has."""
    return ARENA_ROWS + hunters * HUNTER_ROWS + slots * TARGET_ROWS + hunters * targets_seen


@accessor
def targets_of(block: Block, s: Settings) -> Targets:
    """The target slots of a block."""
    first = (ARENA_ROWS + s.hunters * HUNTER_ROWS) * LANES
    size = s.slots * LANES
    return Targets(
        block[first : first + size],
        block[first + size : first + 2 * size],
        block[first + 2 * size : first + 3 * size],
        block[first + 3 * size : first + 4 * size],
        block[first + 4 * size : first + 5 * size],
    )


@accessor
def seat_of(block: Block, seat: int) -> Block:
    """The rows of one seat."""
    first = ARENA_ROWS * LANES + seat * SEAT_SIZE
    return block[first : first + SEAT_SIZE]


@accessor
def view_of(block: Block, seat: int, s: Settings) -> Block:
    """The slots that one seat sees, by rank: rank r of lane l lies at (r - 1) * LANES + l."""
    first = (ARENA_ROWS + s.hunters * HUNTER_ROWS + s.slots * TARGET_ROWS + seat * s.targets_seen) * LANES
    return block[first : first + s.targets_seen * LANES]
