"""Rulebook A.5: counter-based random numbers: a draw depends on its key and its counter, and not on any earlier draw.

SplitMix64's finaliser: Steele, Lea and Flood, «Fast splittable pseudorandom number generators», OOPSLA 2014.
"""

from typing import Final

import numpy as np

from catch_arena.core import rows
from catch_arena.core.jit import Rows, rule

_GOLDEN: Final = np.uint64(0x9E3779B97F4A7C15)
_FIRST: Final = np.uint64(0xBF58476D1CE4E5B9)
_SECOND: Final = np.uint64(0x94D049BB133111EB)

START: Final = np.uint64(1)
PLACE: Final = np.uint64(2)
TIE_LOT: Final = np.uint64(3)
SERVICE_LOT: Final = np.uint64(4)
KILL_DOWN: Final = np.uint64(5)
KILL_REFUSED: Final = np.uint64(6)
SPAWN_DOWN: Final = np.uint64(7)
SPAWN_REFUSED: Final = np.uint64(8)
NEXT_EPISODE: Final = np.uint64(9)
BATCH_ROW: Final = np.uint64(10)
WANDER_TURN: Final = np.uint64(11)
THREAT_LOT: Final = np.uint64(12)
VIEW_NOISE: Final = np.uint64(13)
DROPOUT: Final = np.uint64(14)


@rule
def mix(z: np.uint64) -> np.uint64:
    """A.5: return a permutation of the 64-bit words without visible pattern."""
    z = (z ^ (z >> np.uint64(30))) * _FIRST
    z = (z ^ (z >> np.uint64(27))) * _SECOND
    return z ^ (z >> np.uint64(31))


@rule
def stream(seed: np.uint64, purpose: np.uint64) -> np.uint64:
    """A.5: return the key of a stream of draws, one stream for each seed and purpose."""
    return mix(mix(seed + _GOLDEN) + purpose * _GOLDEN)


@rule
def draw(key: np.uint64, counter: np.uint64) -> np.uint64:
    """A.5: return the counter-th word of a stream."""
    return mix(key + (counter + np.uint64(1)) * _GOLDEN)


@rule
def seed_of(chunk: Rows, lane: int) -> np.uint64:
    """Return an arena's seed, from its two halves of 32 bits."""
    return (np.uint64(chunk[rows.SEED_HIGH + lane]) << np.uint64(32)) | np.uint64(chunk[rows.SEED_LOW + lane])


@rule
def fraction(bits: np.uint64) -> float:
    """A.5: return a word as a number in [0, 1), from its leading 53 bits."""
    return np.float64(bits >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@rule
def tie_lot(seed: np.uint64, step: float, number: float, seat: int) -> np.uint64:
    """R5.5: return a hunter's lot for one target; the lowest wins."""
    return draw(draw(draw(stream(seed, TIE_LOT), np.uint64(step)), np.uint64(number)), np.uint64(seat))


@rule
def service_lot(seed: np.uint64, step: float, seat: int) -> np.uint64:
    """R5.9: return a hunter's position in the queue of a step under `first_come`; the lowest is served first."""
    return draw(draw(stream(seed, SERVICE_LOT), np.uint64(step)), np.uint64(seat))


@rule
def kill_service_down(seed: np.uint64, step: float, rate: float) -> bool:
    """R8.3: return whether the kill service is down in a step. Rate 0 makes no draw, which would cost time."""
    return rate > 0.0 and fraction(draw(stream(seed, KILL_DOWN), np.uint64(step))) < rate


@rule
def kill_refused(seed: np.uint64, step: float, number: float, rate: float) -> bool:
    """R8.3: return whether the simulator refuses to kill one target in one step."""
    return rate > 0.0 and fraction(draw(draw(stream(seed, KILL_REFUSED), np.uint64(step)), np.uint64(number))) < rate


@rule
def spawn_service_down(seed: np.uint64, firing: float, rate: float) -> bool:
    """R8.3: return whether the spawn service is down at a firing of the timer."""
    return rate > 0.0 and fraction(draw(stream(seed, SPAWN_DOWN), np.uint64(firing))) < rate


@rule
def spawn_refused(seed: np.uint64, number: float, rate: float) -> bool:
    """R8.3: return whether the simulator refuses a spawn number."""
    return rate > 0.0 and fraction(draw(stream(seed, SPAWN_REFUSED), np.uint64(number))) < rate


@rule
def wander_draw(seed: np.uint64, number: float, period: float) -> float:
    """R3.9: return the turn of a wandering target in one period, a fraction of its greatest turn rate, in [-1, 1)."""
    return 2.0 * fraction(draw(draw(stream(seed, WANDER_TURN), np.uint64(number)), np.uint64(period))) - 1.0


@rule
def threat_lot(seed: np.uint64, step: float, number: float, seat: int) -> np.uint64:
    """R3.10: return a hunter's lot for one target; of equally near hunters the one with the lowest is its threat."""
    return draw(draw(draw(stream(seed, THREAT_LOT), np.uint64(step)), np.uint64(number)), np.uint64(seat))


@rule
def drops_out(seed: np.uint64, step: float, seat: int, rate: float) -> bool:
    """R1.7: return whether a hunter drops out in a step."""
    return rate > 0.0 and fraction(draw(draw(stream(seed, DROPOUT), np.uint64(step)), np.uint64(seat))) < rate


@rule
def next_seed(seed: np.uint64) -> np.uint64:
    """A.5: return the seed of the episode after this one, if a reset names none."""
    return draw(stream(seed, NEXT_EPISODE), np.uint64(0))
