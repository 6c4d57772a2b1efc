"""Arrays by their addresses: compiled code reads and writes what NumPy does, and sees a wrong index where it looks."""

import numba
import numpy as np
import pytest

from catch_arena.core.addresses import by_address, flat
from catch_arena.core.compiler import INTERPRETED

FLAGS = {"nogil": True, "error_model": "numpy", "_nrt": False}
both_ways = pytest.mark.parametrize("made", [lambda f: f, numba.njit(**FLAGS)], ids=["interpreted", "compiled"])
only_compiled = pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")


def numbers(*shape, dtype=np.float64):
    return np.arange(1, 1 + np.prod(shape), dtype=dtype).reshape(shape)


def touch(given, out):
    """Every way in which the core uses an array of three dimensions."""
    table = by_address(given)
    planes, rows, columns = table.shape
    out[0], out[1], out[2], out[3] = planes, rows, columns, table.size + len(table)
    at = 4
    for plane in range(planes):
        for row in range(rows):
            line = table[plane][row]
            for column in range(columns):
                out[at] = table[plane, row, column] + 100.0 * line[column] + 1e4 * flat(table[plane])[row * columns]
                at += 1
    some = table[1:][0:3]
    for plane in range(len(some)):
        out[at + plane] = some[plane, 1, 0] + len(table[2:9]) + len(table[: plane + 1])
        out[at + plane] += 50 * len(table[5:9]) + 50 * len(table[3:1])
        some[plane, 0, 1] = -some[plane, 0, 1]
        some[plane, 0, 0] += 0.5
    first = flat(table)[2 * columns :]
    first[0] = 7
    first[np.uint64(1)] = first[0] + 1


@both_ways
@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.int64, np.int32, np.int8])
def test_what_is_read_and_written_is_what_numpy_has(made, dtype):
    given = numbers(4, 3, 2, dtype=dtype)
    out = np.zeros(4 + given.size + 3)
    made(touch)(given, out)

    values = numbers(4, 3, 2, dtype=dtype).astype(np.float64)
    heads = np.repeat(values[:, :, 0], 2, axis=1).reshape(4, 3, 2)
    assert out[:4].tolist() == [4, 3, 2, 24 + 4]
    assert out[4:28].tolist() == (101 * values + 10000 * heads).reshape(-1).tolist()
    assert out[28:].tolist() == [values[1 + plane, 1, 0] + 2 + plane + 1 for plane in range(3)]
    written = numbers(4, 3, 2, dtype=dtype)
    written[1:, 0, 1] *= -1
    written[1:, 0, 0] = (written[1:, 0, 0] + 0.5).astype(dtype)
    written[0, 2] = 7, 8
    assert given.tolist() == written.tolist()


@only_compiled
@pytest.mark.parametrize("index", [(-1, 0), (0, -1), (2, 0), (0, 3)])
def test_an_index_outside_is_noticed_where_indices_are_tested(index):
    """NUMBA_BOUNDSCHECK=1; none counts from the end."""

    def read(given, row, column):
        return by_address(given)[row, column]

    def read_row(given, row, column):
        return by_address(given)[row][column]

    def write(given, row, column):
        by_address(given)[row, column] = 0.0
        return 0.0

    for function in (read, read_row, write):
        checked = numba.njit(boundscheck=True, **FLAGS)(function)
        checked(numbers(2, 3), 1, 2)
        with pytest.raises(IndexError):
            checked(numbers(2, 3), *index)
