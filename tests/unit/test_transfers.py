"""Numbers moved between arrays: compiled and interpreted, they arrive where they should, and nowhere else."""

import numpy as np
import pytest

from catch_arena.core.addresses import by_address
from catch_arena.core.jit import phase, unkept_entry
from catch_arena.core.tiles import BodyTile, TargetTile
from catch_arena.core.transfers import TILE, put_exactly, put_rows, stream_eight, take_tile, where_present
from catch_arena.core.vectors import SINGLE, WIDE, group

SIZE = 64
NUMBERS = np.random.default_rng(5).normal(scale=1e3, size=SIZE)
OTHERS = np.random.default_rng(6).normal(scale=1e3, size=SIZE)


def interpreted(function):
    """A phase of the core as plain Python, whether it is compiled or not."""
    return getattr(function, "py_func", function)


both_ways = pytest.mark.parametrize("made", [lambda f: f, unkept_entry], ids=["interpreted", "compiled"])


def columns_of(count):
    """A function of a lane that gives so many columns: row by row of eight lanes."""
    numbers = ", ".join(f"a[{column} * 8 + lane]" for column in range(count))
    return phase(eval(f"lambda a, lane: ({numbers},)"))  # noqa: S307 - a tuple whose length the compiler knows


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("width", [SINGLE, WIDE], ids=["one", "eight"])
@pytest.mark.parametrize("count", [4, 5, 6, 7, 8, 9, 12, 13, 15, 16, 17])
@both_ways
def test_any_number_of_columns_is_put_and_nothing_else_is_written(made, count, width, dtype):
    """Exactly, or up to the next four."""
    columns = columns_of(count) if made is unkept_entry else interpreted(columns_of(count))

    def put(a, width, exact, whole):
        a, exact, whole = by_address(a), by_address(exact), by_address(whole)
        put_exactly(exact, 3, 24, columns(a, group(0, width)))
        put_rows(whole, 3, 24, columns(a, group(0, width)))

    numbers = np.random.default_rng(count).normal(size=(count, 8))
    exact, whole = (np.full(8 * 24, np.nan, dtype=dtype) for _ in range(2))
    made(put)(numbers.reshape(-1), width, exact, whole)
    wanted = numbers[:, : len(width)].T.astype(dtype)
    for out, most in ((exact, 0), (whole, 3)):
        rows = out[: len(width) * 24].reshape(len(width), 24)
        assert (rows[:, 3 : 3 + count] == wanted).all()
        assert np.isnan(rows[:, :3]).all()
        assert np.isnan(rows[:, 3 + count + most :]).all()


@pytest.mark.parametrize("width", [SINGLE, WIDE], ids=["one", "eight"])
@both_ways
def test_a_tile_is_taken_from_another_place_in_each_lane(made, width):
    """In lanes where there is one; and what `put_rows` put there."""
    source = np.random.default_rng(3)
    numbers, indices = source.normal(size=(20, TILE)), source.permutation(20)[:8]

    def take(tiles, indices, width, out):
        tiles, indices, out = by_address(tiles), by_address(indices), by_address(out)
        index = indices[group(0, width)]
        present = index < 12
        put_exactly(out, 0, 12, where_present(present, take_tile(tiles, index)))

    out = np.full((8, 12), np.nan)
    made(take)(numbers.reshape(-1), indices, width, out.reshape(-1))
    for lane, index in enumerate(indices[: len(width)]):
        assert (out[lane, :TILE] == (numbers[index] if index < 12 else 0.0)).all()
        assert np.isnan(out[lane, TILE:]).all()
    assert np.isnan(out[len(width) :]).all()


def test_a_tile_has_room_for_what_is_known_of_anything():
    """The numbers of a moving target stand in one tile."""
    assert len(BodyTile._fields) <= TILE
    assert len(TargetTile._fields) <= TILE


@both_ways
def test_eight_numbers_are_streamed(made):
    """From a place that lies on 32 bytes to such a place."""
    memory = np.zeros((2, 64), dtype=np.float32)
    source, out = (row[-row.ctypes.data % 32 // 4 :][:40] for row in memory)
    source[:] = np.arange(40)
    made(lambda source, out: stream_eight(by_address(out), 24, by_address(source), 8))(source, out)
    assert (out[24:32] == np.arange(8, 16)).all()
    assert not out[:24].any()
    assert not out[32:].any()
