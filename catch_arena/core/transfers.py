"""Numbers moved between arrays, many in one instruction: columns become rows, rows are copied, stores go past the
caches, and what is read next is asked for early.

Each function but the last is written twice, as those of `vectors` are: for Python and for the compiler.
"""

from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numpy.typing import NDArray

from catch_arena.core.jit import phase
from catch_arena.core.vectors import INT32, Vector, compiled_as, like, low_level, pointer_to, shuffle

COPIED: Final = 8
"""How many numbers `copy_eight` and `stream_eight` copy."""
FOUR: Final = 4
"""As many `copy_four` copies, and `put_rows` writes a multiple of."""
PREFETCHED: Final = 8
"""How many numbers of float64 a cache line has: `prefetch` asks for one."""


class Place(NamedTuple):
    """Where the observations of a group of lanes are written."""

    out: NDArray[np.float32]
    """Observations, flat."""
    at: int
    """Where those of the first lane begin."""
    stride: int
    """How far behind them those of the next lane begin."""


# ---- for Python ----


def put_rows(out: NDArray[np.float32], at: int, stride: int, columns: tuple[float, ...]) -> None:
    """Columns become rows: the first lane's numbers, rounded to float32, stand side by side from out[at] on, the next
    lane's from out[at + stride] on. Compiled it takes one lane or eight. With eight it writes whole fours: up to three
    numbers too many.
    """
    count, lanes = len(columns), max(map(np.size, columns))
    rows = np.empty((count, lanes))
    for index, column in enumerate(columns):  # a plain number holds in all lanes
        rows[index] = column
    for lane in range(lanes):
        out[at + lane * stride : at + lane * stride + count] = rows[:, lane]


def copy_four(out: NDArray[np.float32], at: int, source: NDArray[np.float32], start: int) -> None:
    """Four numbers, in one load and one store."""
    out[at : at + 4] = source[start : start + 4]


def copy_eight(out: NDArray[np.float32], at: int, source: NDArray[np.float32], start: int) -> None:
    """Eight numbers, in one load and one store."""
    out[at : at + COPIED] = source[start : start + COPIED]


def stream_eight(out: NDArray[np.float32], at: int, source: NDArray[np.float32], start: int) -> None:
    """Eight numbers, past the caches where `at` lies on 32 bytes."""
    out[at : at + COPIED] = source[start : start + COPIED]


def prefetch(numbers: NDArray[np.float64], at: int) -> None:
    """Ask for the cache line of numbers[at], which is read later. It comes into the second cache: the first is too
    small to keep it until then.
    """


# ---- for the compiler ----


def _transposed(builder: Any, columns: list[Any]) -> list[Any]:
    """Eight lanes of four or eight columns, as eight rows.

    Two rounds of shuffles within the halves of a register, each pairing columns, and one across them, since halves are
    dear to cross.
    """
    pairs = [
        shuffle(builder, columns[k], columns[k + 1], chosen)
        for k in range(0, len(columns), 2)
        for chosen in ([0, 8, 1, 9, 4, 12, 5, 13], [2, 10, 3, 11, 6, 14, 7, 15])
    ]
    fours = [
        [
            shuffle(builder, pairs[k + which], pairs[k + which + 2], chosen)
            for which in (0, 1)
            for chosen in ([0, 1, 8, 9, 4, 5, 12, 13], [2, 3, 10, 11, 6, 7, 14, 15])
        ]
        for k in range(0, len(pairs), 4)
    ]  # the k-th of them has four columns of the lanes k and k + 4
    if len(fours) == 1:
        return [shuffle(builder, one, one, [half + i for i in range(4)]) for half in (0, 4) for one in fours[0]]
    return [
        shuffle(builder, left, right, [half + i for i in (0, 1, 2, 3, 8, 9, 10, 11)])
        for half in (0, 4)
        for left, right in zip(*fours, strict=True)
    ]


def _type_of_put_rows(out: Any, _at: Any, _stride: Any, columns: Any) -> Any:
    return types.void(out, types.int64, types.int64, columns) if isinstance(columns, types.BaseTuple) else None


@compiled_as(put_rows, _type_of_put_rows, 4)
def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    out, at, stride, columns = arguments
    given = signature.args[3]
    number = next((like(each, types.float32) for each in given if isinstance(each, Vector)), types.float32)
    parts = [
        context.cast(builder, part, each, number)
        for part, each in zip(cgutils.unpack_tuple(builder, columns, len(given)), given, strict=True)
    ]
    if not isinstance(number, Vector):
        for index, part in enumerate(parts):
            to = pointer_to(context, builder, signature.args[0], out, builder.add(at, at.type(index)), number)
            builder.store(part, to)
        return context.get_dummy_value()
    nothing = ir.Constant(low_level(number), None)
    for first in range(0, len(parts), 8):
        some = parts[first : first + 8]
        some += [nothing] * (-len(some) % 4)
        row = Vector(types.float32, len(some))
        offset = builder.add(at, at.type(first))
        for value in _transposed(builder, some):
            builder.store(value, pointer_to(context, builder, signature.args[0], out, offset, row), align=4)
            offset = builder.add(offset, stride)
    return context.get_dummy_value()


def _type_of_copy(out: Any, _at: Any, source: Any, _start: Any) -> Any:
    return types.void(out, types.int64, source, types.int64)


def _copy(function: Callable[..., Any], count: int, *, streamed: bool = False) -> None:
    vector = Vector(types.float32, count)
    align = 32 if streamed else 4

    @compiled_as(function, _type_of_copy, 4)
    def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        out, at, source, start = arguments
        numbers = builder.load(pointer_to(context, builder, signature.args[2], source, start, vector), align=align)
        stored = builder.store(numbers, pointer_to(context, builder, signature.args[0], out, at, vector), align=align)
        if streamed:
            stored.set_metadata("nontemporal", builder.module.add_metadata([INT32(1)]))
        return context.get_dummy_value()


_copy(copy_four, 4)
_copy(copy_eight, COPIED)
_copy(stream_eight, COPIED, streamed=True)


@compiled_as(prefetch, lambda numbers, _at: types.void(numbers, types.int64), 2)
def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    byte = ir.IntType(8).as_pointer()
    array, at = arguments
    line = builder.bitcast(pointer_to(context, builder, signature.args[0], array, at, types.float64), byte)
    kind = ir.FunctionType(ir.VoidType(), [byte, INT32, INT32, INT32])
    function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8")
    to_read, second_cache, data = INT32(0), INT32(2), INT32(1)
    builder.call(function, [line, to_read, second_cache, data])
    return context.get_dummy_value()


# ---- for both ----


@phase
def copy_rank(
    out: NDArray[np.float32], at: int, features: NDArray[np.float32], start: int, columns: int, exactly: bool
) -> None:
    """What is seen of one target or body, in as few copies as there can be; the last may overlap the one before it.

    The compiler has to know how many columns there are: call this with a constant, and no loop remains.

    Args:
        out: observations, flat.
        at: where in `out` the columns of its rank begin.
        features: what is seen, with room for COPIED numbers of each: see `workspace.FEATURE_STRIDE`.
        start: where in `features` it begins.
        columns: how many there are, at least FOUR.
        exactly: whether nothing may be written behind them. Else up to FOUR numbers are; the rank that is written next
            begins there, and has as many.
    """
    if columns >= COPIED:
        for offset in range(0, columns - COPIED, COPIED):
            copy_eight(out, at + offset, features, start + offset)
        copy_eight(out, at + columns - COPIED, features, start + columns - COPIED)
    elif exactly:
        for offset in range(0, columns - FOUR, FOUR):
            copy_four(out, at + offset, features, start + offset)
        copy_four(out, at + columns - FOUR, features, start + columns - FOUR)
    else:
        copy_eight(out, at, features, start)
