"""Compiled code sees an index outside an array if NUMBA_BOUNDSCHECK=1 is set."""

import numba
import numpy as np
import pytest

from catch_arena.core.addresses import by_address
from catch_arena.core.modes import INTERPRETED
from catch_arena.core.vectors import WIDE, any_of, group

FLAGS = {"nogil": True, "error_model": "numpy", "_nrt": False, "boundscheck": True}


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
@pytest.mark.parametrize("index", [(-1, 0), (0, -1), (2, 0), (0, 3)])
def test_an_index_outside_is_noticed(index):
    """None counts from the end."""

    def read(given, row, column):
        return by_address(given)[row, column]

    def read_row(given, row, column):
        return by_address(given)[row][column]

    def write(given, row, column):
        by_address(given)[row, column] = 0.0
        return 0.0

    for function in (read, read_row, write):
        checked = numba.njit(**FLAGS)(function)
        checked(np.zeros((2, 3)), 1, 2)
        with pytest.raises(IndexError):
            checked(np.zeros((2, 3)), *index)


def test_both_ends_of_a_group_of_lanes_are_tested():
    def read(row, width, first):
        return any_of(by_address(row)[group(first, width)] > 0.0)

    checked = numba.njit(**FLAGS)(read)
    row = np.zeros(12)
    assert not checked(row, WIDE, 4)
    with pytest.raises(IndexError):
        checked(row, WIDE, 5)
