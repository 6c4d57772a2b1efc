"""The arena memory: the whole state of an arena, as rows of float64 in chunks of LANES arenas.

A chunk is one flat, contiguous slice: row r of lane l lies at r * LANES + l. One arena is one column, and a copy of
that column saves it. A row is one number of each arena, and the constants below are offsets: r * LANES.

The rows of a chunk: the arena's own, HUNTER_ROWS for each seat, a few for each slot, and PREY_ROWS for each prey.
Integers are exact in float64; a seed needs two of them. Alive targets fill the slots from 0 in spawning order (R8.2);
all other slots are zero.
"""

from typing import Final

from catch_arena.core.vectors import LANES
from catch_arena.verdicts import Verdict

# The rows: meaning [unit], range. A count, a number or a time has no upper limit but the episode's end.
# arena rows; the first eight stand in the digest in this order (A.8)
TIME: Final = 0 * LANES  # since reset [ms], from 0
STEP: Final = 1 * LANES  # steps played, from 0
SPAWNED: Final = 2 * LANES  # targets that appeared, less those killed by name (R8.1), from 0
LAST_NUMBER: Final = 3 * LANES  # the last spawn number, from 1; 0 before the first
FIRINGS: Final = 4 * LANES  # firings of the spawn timer, from 0
SKIPPED_FULL: Final = 5 * LANES  # R3.5: firings in a full arena, from 0
SKIPPED_DOWN: Final = 6 * LANES  # R3.6: firings while the spawn service was down, from 0
SPAWNS_REFUSED: Final = 7 * LANES  # R3.6: firings that were refused, from 0
ARENA_DIGEST_ROWS: Final = 8
ALIVE: Final = 8 * LANES  # targets alive, which fill the slots from 0: 0 to MOST
ENDED: Final = 9 * LANES  # RUNNING, TERMINATED or TRUNCATED (R1.5)
SEED_HIGH: Final = 10 * LANES  # the seed's upper 32 bits: 0 to 2^32 - 1
SEED_LOW: Final = 11 * LANES  # the seed's lower 32 bits: 0 to 2^32 - 1
ARENA_ROWS: Final = 12

# body rows: of a hunter or a target; still targets have only the first three
X: Final = 0 * LANES  # [m], 0 to the arena's side
Y: Final = 1 * LANES  # [m], 0 to the arena's side
THETA: Final = 2 * LANES  # heading [rad]: of hunters in [-pi, pi), of still targets as drawn, in [0, 2 pi), or given
STILL_BODY_ROWS: Final = 3
SPEED: Final = 3 * LANES  # commanded [m/s], within the limits of the hunter, the targets or the prey
TURN_RATE: Final = 4 * LANES  # commanded [rad/s], within the same limits
AT_WALL: Final = 5 * LANES  # R2.3's flag: 0 or 1
SINE: Final = 6 * LANES  # sine of theta, -1 to 1: `observe` writes it, and the next step moves by it
COSINE: Final = 7 * LANES  # cosine of theta, -1 to 1, as SINE
BODY_ROWS: Final = 8

# hunter rows: a body's, and these
DISTANCE_INTEGRAL: Final = 8 * LANES  # R4.3 [m s], from 0
BEARING_INTEGRAL: Final = 9 * LANES  # R4.3 [rad s], any number
ACTIVE: Final = 10 * LANES  # spawn number of the active target, from 1; 0 for none
SCORE: Final = 11 * LANES  # granted catches, from 0
WITHDRAWN: Final = 12 * LANES  # R1.6's flag: 0 or 1
REQUESTED_NUMBER: Final = 13 * LANES  # spawn number of the requested target, from 1; 0 for none
VERDICT: Final = 14 * LANES  # R5.2: a number of Verdict, from 1; 0 for no request, and then RULING's other rows are old
DISTANCE: Final = 15 * LANES  # R5.6: distance to the target [micrometres], from 0, or NOT_MEASURED
WINNER: Final = 16 * LANES  # R5.6: the winner's seat, from 0, or NO_SEAT
REWARD_SUM: Final = 17 * LANES  # sum of rewards in this episode, any number
TALLIES: Final = 18 * LANES  # row TALLIES + v * LANES: number of verdicts v, from 1, in this episode; from 0
CONTESTS_WON: Final = TALLIES  # kills, granted or refused, won against a rival's claim, from 0: no verdict has number 0
HUNTER_ROWS: Final = 19 + len(Verdict)
SEAT_SIZE: Final = HUNTER_ROWS * LANES
HUNTER_DIGEST: Final = (
    X,
    Y,
    THETA,
    SPEED,
    TURN_RATE,
    DISTANCE_INTEGRAL,
    BEARING_INTEGRAL,
    ACTIVE,
    SCORE,
    AT_WALL,
    WITHDRAWN,
)
"""A.8: rows of a hunter in the digest, in this order."""
RULING: Final = (REQUESTED_NUMBER, VERDICT, DISTANCE, WINNER)
"""R5.6: rows with the ruling on a hunter's request, one after the other."""
AT_REST: Final = (SPEED, TURN_RATE, DISTANCE_INTEGRAL, BEARING_INTEGRAL, ACTIVE)
"""Rows of a hunter that are zero while no action drives it."""

# slot rows: two, and a body's; if targets move, two more
NUMBER: Final = 0 * LANES  # the target's spawn number, from 1
APPEARED: Final = 1 * LANES  # when it appeared [ms since reset]; less than 0 if it was placed with an age
BODY: Final = 2 * LANES  # the first row of the target's body
WANDER: Final = (2 + BODY_ROWS) * LANES  # R3.9's draw, a fraction of the greatest turn rate: -1 to 1
WANDER_ENDS: Final = (3 + BODY_ROWS) * LANES  # when the next one is drawn [ms since reset], from 0
STILL_SLOT_ROWS: Final = 2 + STILL_BODY_ROWS
MOVING_SLOT_ROWS: Final = 4 + BODY_ROWS
TARGET_X: Final = BODY + X
TARGET_Y: Final = BODY + Y
TARGET_DIGEST: Final = (NUMBER, TARGET_X, TARGET_Y, BODY + THETA, APPEARED)
"""A.8: rows of a target in the digest, in this order."""
MOVING_TARGET_DIGEST: Final = (*TARGET_DIGEST, BODY + SPEED, BODY + TURN_RATE, BODY + AT_WALL)
"""A.8: rows of a moving target in the digest, in this order."""

# prey rows (chapter 12); the slot of prey's target has its pose and motion
PREY_SLOT: Final = 0 * LANES  # slot of the target that it plays, from 0; NO_TARGET while it is out
TIMES_CAUGHT: Final = 1 * LANES  # catches in this episode, from 0
CAUGHT_AT: Final = 2 * LANES  # time of the state on which it was caught [ms since reset], from 0, or NOT_CAUGHT
CAUGHT_BY: Final = 3 * LANES  # the seat that caught it in the last step, from 0, or NO_SEAT
PREY_WITHDRAWN: Final = 4 * LANES  # R12.5's flag: 0 or 1
PREY_REWARD_SUM: Final = 5 * LANES  # sum of rewards in this episode, any number
PREY_ROWS: Final = 6
PREY_SIZE: Final = PREY_ROWS * LANES

# codes in place of a slot or of another number of a target
NO_TARGET: Final = -1  # no target is requested; prey is out
MALFORMED_REQUEST: Final = -2  # the request is not a rank with a target, or not even a name
NEVER_SPAWNED: Final = -3  # no target has had the name
ALREADY_GONE: Final = -4  # a target had the name and is gone

NO_SEAT: Final = -1  # in place of a seat: there is no winner, catcher or nearest hunter
NOT_MEASURED: Final = -1  # in place of a distance: reach was not tested, or there is nothing to measure to
NOT_CAUGHT: Final = -1  # in place of the time of a catch: the prey is in play

# columns of a record: an agent's episode in figures
FINAL_SCORE: Final = 0  # catches of a hunter, or of prey the times it was caught, from 0
FINAL_RANK: Final = 1  # R6.1, R11.1, R12.5: 1 + the number of teams that have more, or of prey that is ahead; from 1
FINAL_REWARD_SUM: Final = 2  # sum of rewards, any number
FINAL_CONTESTS_WON: Final = 3  # as CONTESTS_WON, from 0; of hunters, as all columns that follow
FINAL_TALLIES: Final = 4  # column FINAL_TALLIES + v - 1: number of verdicts v, from 0
FINAL_TEAM_SCORE: Final = FINAL_TALLIES + len(Verdict)  # R11.1, from 0; only if there are teams

RUNNING: Final = 0.0
TERMINATED: Final = 1.0
TRUNCATED: Final = 2.0
