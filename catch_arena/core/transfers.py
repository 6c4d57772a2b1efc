"""Moves of numbers between arrays, several in one instruction: exchanges of columns and rows, stores past the caches,
and prefetches.

Each function is written twice, as in `vectors`: for Python and for the compiler.
"""

from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numpy.typing import NDArray

from catch_arena.core.extending import INT32, compiled_as
from catch_arena.core.vectors import Vector, Width, group, like, low_level, pointer_to, select, shuffle

STREAMED: Final = 8
"""Number of float32 that `stream_eight` copies."""
PREFETCHED: Final = 8
"""Number of float64 in a cache line, which `prefetch` requests."""
TILE: Final = 8
"""Number of float64 in a tile, which is a cache line: see `features`."""


class Place(NamedTuple):
    """Place at which the observations of a group of lanes are written."""

    out: NDArray[np.float32]
    """Observations, flat."""
    at: int
    """Offset of the first lane's observation."""
    stride: int
    """Distance from one lane's observation to the next lane's."""


# ---- for Python ----


def put_rows(out: NDArray[Any], at: int, stride: int, columns: tuple[float, ...]) -> None:
    """Write columns as rows: the first lane's numbers, rounded to `out`'s type, are adjacent from out[at] on, and the
    next lane's from out[at + stride] on. Compiled code takes one lane or eight. With eight it writes whole groups of
    four: up to three numbers after the end.
    """
    count, lanes = len(columns), max(map(np.size, columns))
    rows = np.empty((count, lanes))
    for index, column in enumerate(columns):  # a plain number is the same in all lanes
        rows[index] = column
    for lane in range(lanes):
        out[at + lane * stride : at + lane * stride + count] = rows[:, lane]


def put_exactly(out: NDArray[Any], at: int, stride: int, columns: tuple[float, ...]) -> None:
    """Write four or more columns as rows, with no number after the end: the last four may overlap others."""
    put_rows(out, at, stride, columns)


def take_tile(tiles: NDArray[np.float64], item: int, width: Width) -> tuple[float, ...]:
    """Return rows as columns: the numbers of the tile of a slot, seat or prey, which may differ by lane."""
    index = item * len(width) + group(0, width)
    return tuple(tiles[index * TILE + number] for number in range(TILE))


def where_present(present: bool, columns: tuple[float, ...]) -> tuple[float, ...]:
    """Return the columns in lanes in which `present` is true, and zeros in the others."""
    return tuple(select(present, column, 0.0) for column in columns)


def stream_eight(out: NDArray[np.float32], at: int, source: NDArray[np.float32], start: int) -> None:
    """Copy eight numbers past the caches; both places are aligned to 32 bytes."""
    out[at : at + STREAMED] = source[start : start + STREAMED]


def prefetch(numbers: NDArray[np.float64], at: int) -> None:
    """Prefetch the cache line of numbers[at], which is read later. It comes into the second cache: the first is too
    small to keep it until then.
    """


# ---- for the compiler ----


def _exchanged(builder: Any, rows: list[Any], sides: tuple[int, ...]) -> list[Any]:
    """Exchange the upper right and the lower left quarter of all squares of rows of eight lanes. Do so once for each of
    `sides`, half the side of the squares. With 1, 2 and 4, columns become rows and rows become columns.
    """
    for side in sides:
        low = [lane & ~side | (8 if lane & side else 0) for lane in range(8)]
        high = [lane + side for lane in low]
        paired = [(row, rows[index ^ side]) for index, row in enumerate(rows)]
        rows = [
            shuffle(builder, other, own, high) if index & side else shuffle(builder, own, other, low)
            for index, (own, other) in enumerate(paired)
        ]
    return rows


def _transposed(builder: Any, columns: list[Any]) -> list[Any]:
    """Return eight lanes of four or eight columns, as eight rows."""
    if len(columns) == 8:
        return _exchanged(builder, columns, (1, 2, 4))
    both = _exchanged(builder, columns, (1, 2))  # the k-th of them has the rows k and k + 4
    return [shuffle(builder, one, one, [half + i for i in range(4)]) for half in (0, 4) for one in both]


def _type_of_put(out: Any, _at: Any, _stride: Any, columns: Any) -> Any:
    return types.void(out, types.int64, types.int64, columns) if isinstance(columns, types.BaseTuple) else None


def _put(function: Callable[..., Any], pieces_of: Callable[[int], list[tuple[int, int]]]) -> None:
    """Compile a function that writes columns. `pieces_of` their number gives begin and size (4 or 8) of each piece."""

    @compiled_as(function, _type_of_put, 4)
    def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        out, at, stride, columns = arguments
        array, given = signature.args[0], signature.args[3]
        number = next(
            (like(column_type, array.dtype) for column_type in given if isinstance(column_type, Vector)), array.dtype
        )
        parts = [
            context.cast(builder, part, column_type, number)
            for part, column_type in zip(cgutils.unpack_tuple(builder, columns, len(given)), given, strict=True)
        ]
        if not isinstance(number, Vector):
            for index, part in enumerate(parts):
                builder.store(part, pointer_to(context, builder, out, builder.add(at, at.type(index)), number))
            return context.get_dummy_value()
        zero = ir.Constant(low_level(number), None)
        for first, count in pieces_of(len(parts)):
            some = parts[first : first + count]
            some += [zero] * (count - len(some))
            row = Vector(array.dtype, count)
            offset = builder.add(at, at.type(first))
            for value in _transposed(builder, some):
                pointer = pointer_to(context, builder, out, offset, row)
                builder.store(value, pointer, align=array.dtype.bitwidth // 8)
                offset = builder.add(offset, stride)
        return context.get_dummy_value()


_put(put_rows, lambda count: [(first, 4 if count - first <= 4 else 8) for first in range(0, count, 8)])
_put(
    put_exactly,
    lambda count: (
        [(first, 8) for first in range(0, count - 7, 8)]
        + [(min(first, count - 4), 4) for first in range(count - count % 8, count, 4)]
    ),
)


def _type_of_take(tiles: Any, item: Any, width: Any) -> Any:
    return types.UniTuple(like(item, types.float64), TILE)(tiles, like(item, types.int64), width)


@compiled_as(take_tile, _type_of_take, 3)
def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    (tiles, index, _), of_index = arguments, signature.args[1]
    if isinstance(of_index, Vector):
        row, count = Vector(types.float64, TILE), of_index.count
        first = builder.mul(index, ir.Constant(index.type, [count * TILE] * count))
        begins = builder.add(first, ir.Constant(index.type, [lane * TILE for lane in range(count)]))
        places = [builder.extract_element(begins, INT32(lane)) for lane in range(count)]
        rows = [builder.load(pointer_to(context, builder, tiles, place, row), align=8) for place in places]
        columns = _exchanged(builder, rows, (4, 2, 1))
    else:
        first = builder.mul(index, index.type(TILE))
        places = [builder.add(first, first.type(number)) for number in range(TILE)]
        columns = [builder.load(pointer_to(context, builder, tiles, place, types.float64)) for place in places]
    return context.make_tuple(builder, signature.return_type, columns)


@compiled_as(
    where_present,
    lambda present, columns: types.UniTuple(like(present, types.float64), len(columns))(present, columns),
    2,
)
def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    (present, columns), number = arguments, signature.return_type.dtype
    given = signature.args[1]
    zero = ir.Constant(low_level(number), None)
    kept = [
        builder.select(present, context.cast(builder, column, of, number), zero)
        for column, of in zip(cgutils.unpack_tuple(builder, columns, len(given)), given, strict=True)
    ]
    return context.make_tuple(builder, signature.return_type, kept)


@compiled_as(stream_eight, lambda out, _at, source, _start: types.void(out, types.int64, source, types.int64), 4)
def _(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
    (out, at, source, start), eight = arguments, Vector(types.float32, STREAMED)
    numbers = builder.load(pointer_to(context, builder, source, start, eight), align=32)
    stored = builder.store(numbers, pointer_to(context, builder, out, at, eight), align=32)
    stored.set_metadata("nontemporal", builder.module.add_metadata([INT32(1)]))
    return context.get_dummy_value()


@compiled_as(prefetch, lambda numbers, _at: types.void(numbers, types.int64), 2)
def _(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
    byte = ir.IntType(8).as_pointer()
    array, at = arguments
    line = builder.bitcast(pointer_to(context, builder, array, at, types.float64), byte)
    kind = ir.FunctionType(ir.VoidType(), [byte, INT32, INT32, INT32])
    function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8")
    to_read, second_cache, data = INT32(0), INT32(2), INT32(1)
    builder.call(function, [line, to_read, second_cache, data])
    return context.get_dummy_value()
