"""The appendix's arithmetic against the C library's, and against values that can be looked up."""

import math
import random
import struct

import pytest
from oracle import arithmetic
from oracle.arithmetic import (
    GOLDEN,
    NEXT_SEED,
    PI,
    PLACE,
    RIGHT,
    ROW_SEED,
    TAU,
    WORD,
    atan2,
    draw,
    fraction,
    key,
    mix,
    sincos,
    to_float32,
    wrap,
)

ULP_OF_ONE = 2.0**-52


def test_the_constants_are_the_doubles_that_the_book_means() -> None:
    """PI and TAU are the doubles nearest to pi and 2 pi, and TAU is exactly 2 PI."""
    assert math.pi == PI
    assert math.tau == TAU
    assert 2.0 * PI == TAU
    assert math.pi / 2 == RIGHT


def test_sincos_is_within_one_ulp_of_one_of_the_c_library() -> None:
    """A dense grid over [-2000, 2000], and one over the first turns."""
    points = [2000.0 * (i / 40_000 - 1.0) for i in range(80_001)]
    points += [10.0 * (i / 20_000 - 1.0) for i in range(40_001)]
    worst = 0.0
    for angle in points:
        sine, cosine = sincos(angle)
        worst = max(worst, abs(sine - math.sin(angle)), abs(cosine - math.cos(angle)))
    assert worst < 3e-16


FDLIBM = {
    "P1": "3ff921fb54400000",
    "P2": "3dd0b4611a626331",
    "S1": "bfc5555555555549",
    "S2": "3f8111111110f8a6",
    "S3": "bf2a01a019c161d5",
    "S4": "3ec71de357b1fe7d",
    "S5": "be5ae5e68a2b9ceb",
    "S6": "3de5d93a5acfd57c",
    "C1": "3fa555555555554c",
    "C2": "bf56c16c16c15177",
    "C3": "3efa01a019cb1590",
    "C4": "be927e4f809c52ad",
    "C5": "3e21ee9ebdb4b1c4",
    "C6": "bda8fae9be8838d4",
    "T0": "3fd555555555550d",
    "T1": "bfc999999998ebc4",
    "T2": "3fc24924920083ff",
    "T3": "bfbc71c6fe231671",
    "T4": "3fb745cdc54c206e",
    "T5": "bfb3b0f2af749a6d",
    "T6": "3fb10d66a0d03d51",
    "T7": "bfadde2d52defd9a",
    "T8": "3fa97b4b24760deb",
    "T9": "bfa2b4442c6a6c2f",
    "T10": "3f90ad3ae322da11",
    "HALF_HIGH": "3fddac670561bb4f",
    "HALF_LOW": "3c7a2b7f222f65e2",
    "ONE_HIGH": "3fe921fb54442d18",
    "ONE_LOW": "3c81a62633145c07",
    "RIGHT": "3ff921fb54442d18",
    "RIGHT_LOW": "3c91a62633145c07",
    "PI_LOW": "3ca1a62633145c07",
}
"""The words that fdlibm's sources give beside its constants."""


@pytest.mark.parametrize("name", FDLIBM)
def test_the_books_decimal_digits_identify_fdlibms_constants(name: str) -> None:
    """Bit for bit."""
    assert struct.pack(">d", getattr(arithmetic, name)).hex() == FDLIBM[name]


def test_atan2_is_within_one_ulp_of_the_c_library() -> None:
    """All directions, at several distances, and random points."""
    points = []
    for i in range(60_000):
        angle = TAU * i / 60_000
        scale = (1e-6, 1.0, 15.0, 7000.0)[i % 4]
        points.append((scale * math.sin(angle), scale * math.cos(angle)))
    source = random.Random(4)
    points += [(source.uniform(-12, 12), source.uniform(-12, 12)) for _ in range(20_000)]
    worst = max(abs(atan2(y, x) - math.atan2(y, x)) for y, x in points)
    assert worst < 5e-16  # one ulp of pi is 4.4e-16
    near = max(abs(atan2(y, x) - math.atan2(y, x)) for y, x in points if x > 0)
    assert near < 3e-16  # one ulp of pi / 2 is 2.2e-16


def test_atan2_ignores_the_signs_of_zeros() -> None:
    """The axes and the origin."""
    for zero in (0.0, -0.0):
        assert atan2(zero, 0.0) == 0.0
        assert atan2(zero, -0.0) == 0.0
        assert atan2(zero, 2.0) == 0.0
        assert atan2(zero, -2.0) == PI
        assert atan2(2.0, zero) == RIGHT
        assert atan2(-2.0, zero) == -RIGHT


def test_wrap_lands_in_the_half_open_turn() -> None:
    """Dense, around the seams of many turns, bit by bit, and for the largest angles."""
    angles = [i * 0.013 - 1300.0 for i in range(200_001)]
    for turn in range(-20, 21):
        seam = PI + TAU * turn
        for _ in range(8):
            seam = math.nextafter(seam, -math.inf)
        for _ in range(16):
            angles.append(seam)
            seam = math.nextafter(seam, math.inf)
    for angle in angles:
        wrapped = wrap(angle)
        assert -PI <= wrapped < PI, angle
        sine, cosine = math.sin(angle), math.cos(angle)
        assert abs(math.sin(wrapped) - sine) + abs(math.cos(wrapped) - cosine) < 1e-12, angle


def test_wrap_leaves_an_angle_of_the_turn_alone() -> None:
    """PI itself becomes -PI."""
    for i in range(-3141, 3142):
        assert wrap(i / 1000) == i / 1000
    assert wrap(PI) == -PI
    assert wrap(-PI) == -PI
    assert wrap(math.nextafter(PI, 0.0)) == math.nextafter(PI, 0.0)


def test_rounding_to_float32_takes_the_even_neighbour_of_a_tie() -> None:
    """Exactly half way between two float32 numbers."""
    step = 2.0**-23
    assert to_float32(1.0 + 0.5 * step) == 1.0
    assert to_float32(1.0 + 1.5 * step) == 1.0 + 2.0 * step
    assert to_float32(0.1) == struct.unpack("<f", b"\xcd\xcc\xcc\x3d")[0]
    assert to_float32(11.088889122009277) == 11.088889122009277  # R2.1: turtlesim's side is a float32


def test_draws_are_splitmix64() -> None:
    """The published first outputs of SplitMix64 started from 0 and from 1234567."""
    assert [draw(0, n) for n in range(3)] == [0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4, 0x06C45D188009454F]
    assert [draw(1234567, n) for n in range(3)] == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
    ]


def test_keys_are_two_mixes() -> None:
    """The largest seed does not overflow, and each purpose has a stream of its own."""
    assert mix(0) == 0
    assert key(WORD, PLACE) == mix((mix((WORD + GOLDEN) & WORD) + 2 * GOLDEN) & WORD)
    keys = {key(seed, purpose) for seed in (0, 1, 2**63, WORD) for purpose in range(1, 11)}
    assert len(keys) == 40
    assert {NEXT_SEED, ROW_SEED} == {9, 10}


def test_fractions_lie_in_the_half_open_interval() -> None:
    """The extreme words, and the mean of many."""
    assert fraction(0) == 0.0
    assert fraction(WORD) == 1.0 - 2.0**-53
    assert fraction((1 << 11) - 1) == 0.0
    mean = sum(fraction(draw(7, n)) for n in range(10_000)) / 10_000
    assert abs(mean - 0.5) < 0.01
