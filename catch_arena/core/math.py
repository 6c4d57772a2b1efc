"""Rulebook A.1 to A.4: the project's own elementary functions, so that every machine computes the same bits.

The polynomials are those of fdlibm (Sun Microsystems 1993, k_sin.c, k_cos.c, s_atan.c); results are within 3e-16 of
the true values.
"""

from typing import Final

from catch_arena.core.jit import rule
from catch_arena.core.vectors import floor, select

PI: Final = 3.141592653589793
TAU: Final = 6.283185307179586

_TWO_OVER_PI: Final = 0.6366197723675814
_P1: Final = 1.5707963267341256  # the leading 33 bits of pi/2, and the rest
_P2: Final = 6.077100506506192e-11
_S1, _S2, _S3 = -0.16666666666666632, 0.00833333333332249, -0.0001984126982985795
_S4, _S5, _S6 = 2.7557313707070068e-06, -2.5050760253406863e-08, 1.58969099521155e-10
_C1, _C2, _C3 = 0.0416666666666666, -0.001388888888887411, 2.480158728947673e-05
_C4, _C5, _C6 = -2.7557314351390663e-07, 2.087572321298175e-09, -1.1359647557788195e-11

_T0, _T1, _T2, _T3 = 0.3333333333333293, -0.19999999999876483, 0.14285714272503466, -0.11111110405462356
_T4, _T5, _T6, _T7 = 0.09090887133436507, -0.0769187620504483, 0.06661073137387531, -0.058335701337905735
_T8, _T9, _T10 = 0.049768779946159324, -0.036531572744216916, 0.016285820115365782
_HALF_HIGH, _HALF_LOW = 0.4636476090008061, 2.2698777452961687e-17  # atan(1/2)
_ONE_HIGH, _ONE_LOW = 0.7853981633974483, 3.061616997868383e-17  # atan(1)
_RIGHT, _RIGHT_LOW = 1.5707963267948966, 6.123233995736766e-17  # pi/2
_PI_LOW: Final = 1.2246467991473532e-16


@rule
def clamp(value: float, low: float, high: float) -> float:
    """A.1: return the nearest number of [low, high]. Not by min and max, which may return 0.0 or -0.0."""
    value = select(value < low, low, value)
    return select(value > high, high, value)


@rule
def wrap(angle: float) -> float:
    """A.2: return an angle that has the same direction, in [-pi, pi)."""
    turned = angle - TAU * floor((angle + PI) / TAU)
    turned = select(turned < -PI, turned + TAU, turned)
    return select(turned >= PI, turned - TAU, turned)


@rule
def below_pi(angle: float) -> float:
    """A.2: return an angle of [-pi, pi] in [-pi, pi), with the bits of `wrap`, but without a division."""
    return select(angle >= PI, angle - TAU, angle)


@rule
def sincos(angle: float) -> tuple[float, float]:
    """A.3: return sine and cosine of an angle of at most 2000 rad."""
    turns = floor(angle * _TWO_OVER_PI + 0.5)
    r = (angle - turns * _P1) - turns * _P2
    z = r * r
    s = r + (z * r) * (_S1 + z * (_S2 + z * (_S3 + z * (_S4 + z * (_S5 + z * _S6)))))
    h = 0.5 * z
    u = 1.0 - h
    c = u + (((1.0 - u) - h) + z * (z * (_C1 + z * (_C2 + z * (_C3 + z * (_C4 + z * (_C5 + z * _C6)))))))
    quadrant = turns - 4.0 * floor(turns * 0.25)
    odd = (quadrant == 1.0) | (quadrant == 3.0)
    sine = select(odd, c, s)
    cosine = select(odd, s, c)
    sine = select(quadrant >= 2.0, -sine, sine)
    cosine = select((quadrant == 1.0) | (quadrant == 2.0), -cosine, cosine)
    return sine, cosine


@rule
def atan2(y: float, x: float) -> float:
    """A.4: return the direction of (x, y) in [-pi, pi]; 0 for the origin."""
    p = select(x < 0.0, -x, x)
    q = select(y < 0.0, -y, y)
    low = select(q < p, q, p)
    high = select(q < p, p, q)
    near_zero = low < 0.4375 * high
    near_half = low < 0.6875 * high
    n = select(near_zero, low, select(near_half, 2.0 * low - high, low - high))
    d = select(near_zero, high, select(near_half, 2.0 * high + low, low + high))
    base = select(near_zero, 0.0, select(near_half, _HALF_HIGH, _ONE_HIGH))
    rest = select(near_zero, 0.0, select(near_half, _HALF_LOW, _ONE_LOW))
    r = n / select(d > 0.0, d, 1.0)
    z = r * r
    w = z * z
    odd = z * (_T0 + w * (_T2 + w * (_T4 + w * (_T6 + w * (_T8 + w * _T10)))))
    even = w * (_T1 + w * (_T3 + w * (_T5 + w * (_T7 + w * _T9))))
    angle = base - ((r * (odd + even) - rest) - r)
    angle = select(high == 0.0, 0.0, angle)
    angle = select(q > p, _RIGHT - (angle - _RIGHT_LOW), angle)
    angle = select(x < 0.0, PI - (angle - _PI_LOW), angle)
    return select(y < 0.0, -angle, angle)
