"""Eight keys in order, and two eights merged, without a branch: in registers, in all lanes of a group at once.

By sorting networks of Batcher's (Knuth, The Art of Computer Programming 3, section 5.3.4). Each function is written
twice, as those of `vectors` are: for Python and for the compiler.
"""

from collections.abc import Callable, Iterable
from typing import Any, Final, TypeVar

from numba import types
from numba.core import cgutils

from catch_arena.core.extending import compiled_as
from catch_arena.core.vectors import select

EIGHT: Final = 8
Eight = tuple[int, int, int, int, int, int, int, int]
"""Keys, as int32: in each lane, or a vector of them."""

_ROUNDS: Final = (((0, 2, 4, 6), 1), ((0, 1, 4, 5), 2), ((1, 5), 1), ((0, 1, 2, 3), 4), ((2, 3), 2), ((1, 3, 5), 1))
"""Of the odd-even merge sort: which keys are compared with those so far behind them."""
_SORT: Final = tuple((low, low + apart) for lows, apart in _ROUNDS for low in lows)
_SORT_BITONIC: Final = tuple((low, low + apart) for apart in (4, 2, 1) for low in range(EIGHT) if not low & apart)

T = TypeVar("T")
Ordered = Callable[[T, T], tuple[T, T]]
"""Of two keys the smaller one, and the other."""


def _compared(keys: Iterable[T], comparators: Iterable[tuple[int, int]], ordered: Ordered[T]) -> list[T]:
    """The keys when each comparator has put the smaller one of its two first."""
    found = list(keys)
    for low, high in comparators:
        found[low], found[high] = ordered(found[low], found[high])
    return found


def _halved(one: Iterable[T], other: Iterable[T], ordered: Ordered[T]) -> tuple[list[T], list[T]]:
    """The smaller half and the other, of two eights that are sorted: neither half is, but both first grow and then
    shrink, or the other way round.
    """
    pairs = [ordered(a, b) for a, b in zip(one, reversed(list(other)), strict=True)]
    return [low for low, _ in pairs], [high for _, high in pairs]


# ---- for Python ----


def sorted_eight(keys: Eight) -> Eight:
    """The smallest first."""
    return _eight(_compared(keys, _SORT, _in_order))


def sorted_bitonic(keys: Eight) -> Eight:
    """The same of keys that first grow and then shrink, or the other way round."""
    return _eight(_compared(keys, _SORT_BITONIC, _in_order))


def merged(one: Eight, other: Eight) -> tuple[Eight, Eight]:
    """Of two eights that are sorted the smaller half, sorted, and the rest, which is as `sorted_bitonic` takes it."""
    low, high = _halved(one, other, _in_order)
    return sorted_bitonic(_eight(low)), _eight(high)


def _in_order(a: int, b: int) -> tuple[int, int]:
    return select(a < b, a, b), select(a < b, b, a)


def _eight(keys: list[int]) -> Eight:
    a, b, c, d, e, f, g, h = keys
    return a, b, c, d, e, f, g, h


# ---- for the compiler ----


def _ordered_by(builder: Any) -> Ordered[Any]:
    def ordered(a: Any, b: Any) -> tuple[Any, Any]:
        less = builder.icmp_signed("<", a, b)
        return builder.select(less, a, b), builder.select(less, b, a)

    return ordered


def _sort(function: Callable[..., Any], comparators: Iterable[tuple[int, int]]) -> None:
    @compiled_as(function, lambda keys: keys(keys), 1)
    def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        keys = cgutils.unpack_tuple(builder, arguments[0], EIGHT)
        return context.make_tuple(builder, signature.return_type, _compared(keys, comparators, _ordered_by(builder)))


_sort(sorted_eight, _SORT)
_sort(sorted_bitonic, _SORT_BITONIC)


@compiled_as(merged, lambda one, other: types.UniTuple(one, 2)(one, other), 2)
def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    ordered, eight = _ordered_by(builder), signature.args[0]
    one, other = (cgutils.unpack_tuple(builder, keys, EIGHT) for keys in arguments)
    low, high = _halved(one, other, ordered)
    halves = _compared(low, _SORT_BITONIC, ordered), high
    return context.make_tuple(
        builder, signature.return_type, [context.make_tuple(builder, eight, half) for half in halves]
    )
