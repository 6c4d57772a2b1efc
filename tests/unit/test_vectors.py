"""Lanes as vectors: compiled and interpreted, one, four or eight at a time, every operation gives the same bits."""

import numpy as np
import pytest

from catch_arena.core.addresses import by_address
from catch_arena.core.jit import unkept_entry
from catch_arena.core.vectors import (
    HALF,
    SINGLE,
    WIDE,
    any_of,
    bits_of,
    floor,
    group,
    lane_numbers,
    long,
    number_of,
    select,
    single_bits,
    sqrt,
    truncate,
)

WIDTHS = {"one": SINGLE, "four": HALF, "eight": WIDE}
SPECIAL = (
    0.0,
    -0.0,
    1.0,
    -1.0,
    5e-324,
    -1e-310,
    1e308,
    -1e308,
    np.inf,
    -np.inf,
    np.nan,
    0.5,
    -0.5,
    2.0**52,
    1e-40,
    3.5,
)
NUMBERS = np.concatenate([SPECIAL, np.random.default_rng(5).normal(scale=1e3, size=48)])
OTHERS = np.concatenate([SPECIAL[::-1], np.random.default_rng(6).normal(scale=1e3, size=40), NUMBERS[-8:]])
"""Some of them equal to those of NUMBERS."""
SIZE = len(NUMBERS)


def calculate(a, b, out, width):
    """Every operation of float64, a row for each."""
    a, b, out = by_address(a), by_address(b), by_address(out)
    for first in range(0, SIZE, len(width)):
        lane = group(first, width)
        x, y = a[lane], b[lane]
        out[0 * SIZE + lane] = x + y
        out[1 * SIZE + lane] = x - 2.5
        out[2 * SIZE + lane] = 3 * x * y
        out[3 * SIZE + lane] = x / y
        out[4 * SIZE + lane] = -x
        out[5 * SIZE + lane] = floor(x)
        out[6 * SIZE + lane] = sqrt(x)
        out[7 * SIZE + lane] = 2.0 * (x + y - 1.0)
        out[8 * SIZE + lane] = select(x < y, x, y)
        out[9 * SIZE + lane] = select(x <= y, 1.0, 0.0)
        out[10 * SIZE + lane] = select(x > y, x, 0.0)
        out[11 * SIZE + lane] = select(x >= y, 1, 2)
        out[12 * SIZE + lane] = select(x == y, 1.0, y)
        out[13 * SIZE + lane] = select(x != y, 1.0, 0.0)
        out[14 * SIZE + lane] = select((x < y) & (x > 0.0), 1.0, 0.0)
        out[15 * SIZE + lane] = select((x < y) | (x > 0.0), 1.0, 0.0)
        out[16 * SIZE + lane] = number_of((bits_of(x) & 0xFFFFFFFF) | (long(truncate(select(x > 0.0, 7.0, 3.0))) << 40))
        out[17 * SIZE + lane] = select(first < SIZE // 2, x, 1)
        out[18 * SIZE + lane] = a[(lane_numbers(first, width) * 5 + 3) & (SIZE - 1)]
        out[19 * SIZE + lane] = 1.0 if any_of(x > 1000.0) else 0.0


def expected():
    """Results of NumPy, row by row."""
    x, y = NUMBERS, OTHERS
    high = np.where(x > 0.0, 7, 3).astype(np.int64) << 40
    return np.array(
        [
            x + y,
            x - 2.5,
            3 * x * y,
            x / y,
            -x,
            np.floor(x),
            np.sqrt(x),
            2.0 * (x + y - 1.0),
            np.where(x < y, x, y),
            x <= y,
            np.where(x > y, x, 0.0),
            np.where(x >= y, 1, 2),
            np.where(x == y, 1.0, y),
            x != y,
            (x < y) & (x > 0.0),
            (x < y) | (x > 0.0),
            ((x.view(np.int64) & 0xFFFFFFFF) | high).view(np.float64),
            np.where(np.arange(SIZE) < SIZE // 2, x, 1),
            x[(np.arange(SIZE) * 5 + 3) % SIZE],
        ]
    )


def calculate_keys(a, keys, width):
    """Every operation of int32, a row for each."""
    a, keys = by_address(a), by_address(keys)
    for first in range(0, SIZE, len(width)):
        lane = group(first, width)
        bits = single_bits(a[lane])
        keys[0 * SIZE + lane] = bits
        keys[1 * SIZE + lane] = ((bits + 32) & ~63) | 5
        keys[2 * SIZE + lane] = select(bits < 1 << 20, bits, keys[1 * SIZE + lane])
        keys[3 * SIZE + lane] = select(bits != 0, bits & 7, 9)
        keys[4 * SIZE + lane] = (bits >> 3) - 2


def same_bits(one, other):
    """NaN is NaN: its sign is nobody's promise."""
    return np.array_equal(one, other, equal_nan=True) and np.array_equal(
        np.signbit(one[one == 0]), np.signbit(other[other == 0])
    )


both_ways = pytest.mark.parametrize("made", [lambda f: f, unkept_entry], ids=["interpreted", "compiled"])
at_every_width = pytest.mark.parametrize("width", WIDTHS.values(), ids=WIDTHS)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@both_ways
@at_every_width
def test_float64(made, width):
    out = np.zeros(20 * SIZE)
    made(calculate)(NUMBERS, OTHERS, out, width)
    rows = out.reshape(20, SIZE)
    for row, right in zip(rows, expected(), strict=False):
        assert same_bits(row, right.astype(np.float64))
    per_group = (NUMBERS > 1000.0).reshape(-1, len(width)).any(axis=1)
    assert (rows[19] == np.repeat(per_group, len(width))).all()


@both_ways
@at_every_width
def test_int32(made, width):
    keys = np.zeros(5 * SIZE, dtype=np.int32)
    numbers = np.abs(np.nan_to_num(NUMBERS, posinf=1e30, nan=0.0))
    numbers[numbers > 1e30] = 1e30  # no float32 is larger than 3.4e38
    made(calculate_keys)(numbers, keys, width)
    bits = numbers.astype(np.float32).view(np.int32)
    with_item = ((bits + 32) & ~63) | 5
    right = [
        bits,
        with_item,
        np.where(bits < 1 << 20, bits, with_item),
        np.where(bits != 0, bits & 7, 9),
        (bits >> 3) - 2,
    ]
    assert (keys.reshape(5, SIZE) == right).all()
