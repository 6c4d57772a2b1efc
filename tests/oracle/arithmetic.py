"""The oracle's numbers: the rulebook's appendix A.1 to A.6 in plain Python, as slow and as literal as the book."""

# ruff: noqa: FURB136 - the choices are written as the book writes them: min and max may treat zeros otherwise

import math
import struct
from typing import Final

PI: Final = 3.141592653589793
TAU: Final = 6.283185307179586
DT: Final = 0.016


def clamp(value: float, low: float, high: float) -> float:
    """A.1."""
    return low if value < low else (high if value > high else value)


def floor(value: float) -> float:
    """A.1: the largest whole double that is not above `value`."""
    return float(math.floor(value))


def to_float32(value: float) -> float:
    """A.1: rounded to binary32, to nearest, ties to even."""
    rounded: float = struct.unpack("<f", struct.pack("<f", value))[0]
    return rounded


def wrap(angle: float) -> float:
    """A.2: the same angle in [-PI, PI)."""
    r = angle - TAU * floor((angle + PI) / TAU)
    if r < -PI:
        r = r + TAU
    if r >= PI:
        r = r - TAU
    return r


P1: Final = 1.5707963267341256
P2: Final = 6.077100506506192e-11
TWO_OVER_PI: Final = 0.6366197723675814
S1: Final = -0.16666666666666632
S2: Final = 0.00833333333332249
S3: Final = -0.0001984126982985795
S4: Final = 2.7557313707070068e-06
S5: Final = -2.5050760253406863e-08
S6: Final = 1.58969099521155e-10
C1: Final = 0.0416666666666666
C2: Final = -0.001388888888887411
C3: Final = 2.480158728947673e-05
C4: Final = -2.7557314351390663e-07
C5: Final = 2.087572321298175e-09
C6: Final = -1.1359647557788195e-11


def sincos(angle: float) -> tuple[float, float]:
    """A.3: sine and cosine of an angle of at most 2000 rad."""
    k = floor(angle * TWO_OVER_PI + 0.5)
    r = (angle - k * P1) - k * P2
    z = r * r
    s = r + (z * r) * (S1 + z * (S2 + z * (S3 + z * (S4 + z * (S5 + z * S6)))))
    h = 0.5 * z
    u = 1.0 - h
    c = u + (((1.0 - u) - h) + z * (z * (C1 + z * (C2 + z * (C3 + z * (C4 + z * (C5 + z * C6)))))))
    quadrant = k - 4.0 * floor(k * 0.25)
    if quadrant == 0.0:
        return s, c
    if quadrant == 1.0:
        return c, -s
    if quadrant == 2.0:
        return -s, -c
    return -c, s


T0: Final = 0.3333333333333293
T1: Final = -0.19999999999876483
T2: Final = 0.14285714272503466
T3: Final = -0.11111110405462356
T4: Final = 0.09090887133436507
T5: Final = -0.0769187620504483
T6: Final = 0.06661073137387531
T7: Final = -0.058335701337905735
T8: Final = 0.049768779946159324
T9: Final = -0.036531572744216916
T10: Final = 0.016285820115365782
HALF_HIGH: Final = 0.4636476090008061
HALF_LOW: Final = 2.2698777452961687e-17
ONE_HIGH: Final = 0.7853981633974483
ONE_LOW: Final = 3.061616997868383e-17
RIGHT: Final = 1.5707963267948966
RIGHT_LOW: Final = 6.123233995736766e-17
PI_LOW: Final = 1.2246467991473532e-16


def atan2(y: float, x: float) -> float:
    """A.4: the direction of (x, y) in [-PI, PI]; 0 for the origin."""
    p = -x if x < 0 else x
    q = -y if y < 0 else y
    low = q if q < p else p
    high = p if q < p else q
    if low < 0.4375 * high:
        n, d, base, rest = low, high, 0.0, 0.0
    elif low < 0.6875 * high:
        n, d, base, rest = 2.0 * low - high, 2.0 * high + low, HALF_HIGH, HALF_LOW
    else:
        n, d, base, rest = low - high, low + high, ONE_HIGH, ONE_LOW
    r = n / (d if d > 0 else 1.0)
    z = r * r
    w = z * z
    odd = z * (T0 + w * (T2 + w * (T4 + w * (T6 + w * (T8 + w * T10)))))
    even = w * (T1 + w * (T3 + w * (T5 + w * (T7 + w * T9))))
    a = base - ((r * (odd + even) - rest) - r)
    if high == 0:
        a = 0.0
    if q > p:
        a = RIGHT - (a - RIGHT_LOW)
    if x < 0:
        a = PI - (a - PI_LOW)
    if y < 0:
        a = -a
    return a


WORD: Final = 0xFFFFFFFFFFFFFFFF
GOLDEN: Final = 0x9E3779B97F4A7C15

START_TURN: Final = 1
PLACE: Final = 2
TIE_LOT: Final = 3
SERVICE_LOT: Final = 4
KILL_DOWN: Final = 5
KILL_REFUSED: Final = 6
SPAWN_DOWN: Final = 7
SPAWN_REFUSED: Final = 8
NEXT_SEED: Final = 9
ROW_SEED: Final = 10
WANDER: Final = 11
THREAT_LOT: Final = 12
ERROR: Final = 13
DROPOUT: Final = 14


def mix(z: int) -> int:
    """A.5: SplitMix64's finalizer."""
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & WORD
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & WORD
    return z ^ (z >> 31)


def key(seed: int, purpose: int) -> int:
    """A.5: the key of one stream."""
    return mix((mix((seed + GOLDEN) & WORD) + purpose * GOLDEN) & WORD)


def draw(stream: int, n: int) -> int:
    """A.5: word n of the stream with that key."""
    return mix((stream + (n + 1) * GOLDEN) & WORD)


def fraction(bits: int) -> float:
    """A.5: a word as a number in [0, 1)."""
    return (bits >> 11) * 2.0**-53
