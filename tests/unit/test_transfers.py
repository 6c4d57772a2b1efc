"""Numbers moved between arrays: compiled and interpreted, they arrive where they should, and nowhere else."""

import numba
import numpy as np
import pytest

from catch_arena.core import observations
from catch_arena.core.state import LANES
from catch_arena.core.transfers import PREFETCHED, copy_eight, copy_four, prefetch, put_rows, stream_eight
from catch_arena.core.vectors import SINGLE, WIDE, group, single

FLAGS = {"nogil": True, "error_model": "numpy", "_nrt": False}
"""Those of the core."""
SIZE = 64
NUMBERS = np.random.default_rng(5).normal(scale=1e3, size=SIZE)
OTHERS = np.random.default_rng(6).normal(scale=1e3, size=SIZE)


def interpreted(function):
    """A phase of the core as plain Python, whether it is compiled or not."""
    return getattr(function, "py_func", function)


both_ways = pytest.mark.parametrize("made", [lambda f: f, numba.njit(**FLAGS)], ids=["interpreted", "compiled"])


def write_rows(a, b, out, width):
    """Columns as rows: five, seven and ten of them."""
    for first in range(0, SIZE, len(width)):
        lane = group(first, width)
        x, y = a[lane], b[lane]
        at = first * 32
        put_rows(out, at, 32, (x, y, 1.0, single(y), x))
        put_rows(out, at + 5, 32, (y, x, x, x, y, y, x))
        put_rows(out, at + 12, 32, (x, y, y, y, x, x, 0.5, y, x, y))


def copy(source, out):
    """From places that lie anywhere to such places; streamed to one that lies on 32 bytes."""
    copy_four(out, 3, source, 5)
    copy_eight(out, 9, source, 2)
    stream_eight(out, 32, source, 8)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@both_ways
@pytest.mark.parametrize("width", [SINGLE, WIDE], ids=["one", "eight"])
def test_columns_become_rows(made, width):
    out = np.zeros(32 * SIZE, dtype=np.float32)
    made(write_rows)(NUMBERS, OTHERS, out, width)
    x, y, one = (column.astype(np.float32) for column in (NUMBERS, OTHERS, np.ones(SIZE)))
    columns = [x, y, one, y, x, y, x, x, x, y, y, x, x, y, y, y, x, x, one / 2, y, x, y]
    assert np.array_equal(out.reshape(SIZE, 32)[:, :22], np.transpose(columns), equal_nan=True)


@both_ways
def test_copies(made):
    source = np.arange(64, dtype=np.float32)
    memory = np.zeros(128, dtype=np.float32)
    out = memory[-memory.ctypes.data % 32 // 4 :][:64]
    made(copy)(source[-source.ctypes.data % 32 // 4 :][:40], out)
    first = source[-source.ctypes.data % 32 // 4]
    assert (out[3:7] == first + np.arange(5, 9)).all()
    assert (out[9:17] == first + np.arange(2, 10)).all()
    assert (out[32:40] == first + np.arange(8, 16)).all()
    assert not out[[2, 7, 8, 17, 31, 40]].any()


@both_ways
def test_prefetching_changes_nothing(made):
    numbers = np.arange(3.0 * PREFETCHED)
    made(lambda numbers: prefetch(numbers, 2 * PREFETCHED))(numbers)
    assert (numbers == np.arange(3.0 * PREFETCHED)).all()


@pytest.mark.parametrize("parts", [1, 4, 16, 24, 256])
@pytest.mark.parametrize("rows", [0, 1, 7, 224, 2208])
def test_each_cache_line_of_the_next_block_is_asked_for(monkeypatch, rows, parts):
    asked = []
    ask = interpreted(observations.prefetch_part)
    monkeypatch.setattr(observations, "prefetch", lambda _numbers, at: asked.append(at))
    ahead = np.zeros(rows * LANES)
    for part in range(parts):
        ask(ahead, part, parts)
    assert {at // PREFETCHED for at in asked} == set(range(len(ahead) // PREFETCHED))
    assert len(asked) <= len(ahead) // PREFETCHED + parts
    assert max(asked, default=-1) < len(ahead)


def test_only_what_the_caches_do_not_hold_is_asked_for():
    """The block after the one that is played: none of a small batch, and none after the last."""
    small, large = np.zeros((4, 7 * LANES)), np.broadcast_to(np.zeros(1), (4096, 224 * LANES))
    block_after = interpreted(observations.block_after)
    assert len(block_after(small, 0)) == 0
    assert len(block_after(large, 0)) == 224 * LANES
    assert len(block_after(large, 4094 * LANES)) == 224 * LANES
    assert len(block_after(large, 4095 * LANES)) == 0
