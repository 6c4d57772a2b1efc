"""What the compiler has in place of `range`, `min`, `max` and `int` does as Python's do."""

import itertools

import numba
import numpy as np
import pytest

from catch_arena.core.builtin_functions import int_of, max_of, min_of, range_of
from catch_arena.core.compiler import INTERPRETED, USABLE
from catch_arena.core.jit import phase, unkept_entry

BOUNDS = (-7, -1, 0, 1, 2, 8)
STEPS = (-9, -3, -1, 1, 2, 5)


@unkept_entry
def visit(found, start, stop, step):
    count = 0
    for number in range_of(start, stop, step):
        found[count] = number
        count += 1
    return count


@unkept_entry
def visit_between(found, start, stop):
    count = 0
    for number in range_of(start, stop):
        found[count] = number
        count += 1
    return count


@unkept_entry
def visit_up_to(found, stop):
    count = 0
    for number in range_of(stop):
        found[count] = number
        count += 1
    return count


def test_it_goes_through_the_same_numbers():
    found = np.zeros(100, dtype=np.int64)
    for start, stop in itertools.product(BOUNDS, BOUNDS):
        for step in STEPS:
            assert found[: visit(found, start, stop, step)].tolist() == list(range(start, stop, step))
        assert found[: visit_between(found, start, stop)].tolist() == list(range(start, stop))
        assert found[: visit_up_to(found, np.int32(stop))].tolist() == list(range(stop))


@phase
def nest(found, rows, columns):
    count = 0
    for row in range(rows):
        for column in range(row, columns):
            if column == 5:
                break
            if column % 2 == 1:
                continue
            found[count] = 10 * row + column
            count += 1
            column = -1  # the loop goes on as if nothing had been said  # noqa: PLW2901
        else:
            found[count] = -row
            count += 1
    return count


@unkept_entry
def begin(found, rows, columns):
    return nest(found, rows, columns)


@pytest.mark.parametrize(("rows", "columns"), [(0, 4), (3, 4), (4, 9), (2, 0)])
def test_loops_in_loops_are_left_and_go_on_as_in_python(rows, columns):
    """Where the core says `range`, this is meant."""
    found, expected = np.zeros((2, 100), dtype=np.int64)
    assert begin(found, rows, columns) == getattr(nest, "py_func", nest)(expected, rows, columns)
    assert found.tolist() == expected.tolist()
    if USABLE and not INTERPRETED:
        (compiled,) = nest.overloads.values()
        assert "Counter" in str([*compiled.type_annotation.typemap.values()])


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
def test_what_is_no_whole_number_is_refused_by_the_compiler():
    with pytest.raises(numba.TypingError, match="range_of"):
        visit_up_to(np.zeros(3, dtype=np.int64), 2.0)


NUMBERS = (-3, 0, 5, 2**40, -0.0, 0.0, 2.5, -2.5, float("inf"), float("nan"))


@unkept_entry
def choose_least(a, b):
    return min_of(a, b)


@unkept_entry
def choose_greatest(a, b):
    return max_of(a, b)


def test_the_least_and_the_greatest_of_two_are_pythons():
    """Of 0.0 and -0.0, and of a number and a NaN, too: the first."""
    for a, b in itertools.product(NUMBERS, NUMBERS):
        kind = float if float in (type(a), type(b)) else int
        for ours, pythons in ((choose_least, min), (choose_greatest, max)):
            found = ours(a, b)
            assert INTERPRETED or type(found) is kind
            assert np.float64(found).tobytes() == np.float64(pythons(a, b)).tobytes()


@unkept_entry
def make_whole(value):
    return int_of(value)


def test_a_number_loses_its_fraction():
    for number in (-2.9, -0.1, 0.0, 0.9, 7.0, 1e15 + 0.5, 3, True, np.int8(-7), np.uint64(9)):
        assert make_whole(number) == int(number)
        assert INTERPRETED or type(make_whole(number)) is int


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
def test_the_least_of_what_no_int64_holds_is_refused_by_the_compiler():
    """Python compares numbers from 2**63 on as they are; as an int64 they would be negative."""
    large = np.uint64(2**63 + 5)
    for fail in (lambda: choose_least(large, np.uint64(7)), lambda: choose_greatest(1, large)):
        with pytest.raises(numba.TypingError, match="uint64"):
            fail()
