"""What Python's `range`, `min`, `max` and `int` are for the compiler, which `compiler` puts in their place.

Numba's own `range` makes two objects for each loop, works out beforehand how often it will go round, and takes a third
of all the code that LLVM gets. Its other three are functions that it compiles, optimises and emits, each for each type.
"""

from collections.abc import Callable
from typing import Any, Final, TypeVar

import numba.core.types
from numba.core import cgutils
from numba.extending import lower_builtin, models, register_model

from catch_arena.core.extending import INT64, Emitter, compiled_as, packed, unpacked, whole_number

types: Any = numba.core.types  # Numba has annotations for a part of it only, and not for what is used here

Number = TypeVar("Number", int, float)

# ---- for Python ----


def range_of(start: int, stop: int | None = None, step: int = 1) -> range:
    """`range` of the same arguments; the step is not 0."""
    return range(start) if stop is None else range(start, stop, step)


def min_of(a: Number, b: Number) -> Number:
    """`min` of two."""
    return min(a, b)


def max_of(a: Number, b: Number) -> Number:
    """`max` of two."""
    return max(a, b)


def int_of(value: float) -> int:
    """`int` of a number that an int64 holds."""
    return int(value)


IN_PLACE_OF: Final[dict[Any, Callable[..., Any]]] = {range: range_of, min: min_of, max: max_of, int: int_of}

# ---- for the compiler ----


class _Counter(types.SimpleIteratorType):  # type: ignore[misc]
    """Where a loop is."""


class _Counted(types.SimpleIterableType):  # type: ignore[misc]
    """What it goes through."""


_COUNTER: Final = _Counter("Counter", types.int64)
_COUNTED: Final = _Counted("Counted", _COUNTER)


@register_model(_Counted)
class _CountedModel(models.StructModel):
    def __init__(self, manager: Any, of: Any) -> None:
        super().__init__(manager, of, [(name, types.int64) for name in ("start", "stop", "step")])


@register_model(_Counter)
class _CounterModel(models.StructModel):
    def __init__(self, manager: Any, of: Any) -> None:
        members = ("next", types.CPointer(types.int64)), ("stop", types.int64), ("step", types.int64)
        super().__init__(manager, of, members)


def _type_of_count(start: Any, stop: Any = None, step: Any = None) -> Any:
    given = [bound for bound in (start, stop, step) if bound is not None]
    return _COUNTED if all(isinstance(bound, types.Integer) for bound in given) else None


def _emit_count(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    bounds = [
        whole_number(context, builder, bound, of)
        for bound, of in zip(arguments, signature.args, strict=True)
        if isinstance(of, types.Integer)
    ]
    if len(bounds) == 1:
        bounds.insert(0, INT64(0))
    return packed(context, builder, _COUNTED, bounds if len(bounds) == 3 else [*bounds, INT64(1)])


compiled_as(range_of, _type_of_count, 1)(_emit_count)
for _arity in (2, 3):
    lower_builtin(range_of, *(types.Any,) * _arity)(_emit_count)


@lower_builtin("getiter", _Counted)
def _(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
    start, *others = unpacked(builder, arguments[0])
    here = cgutils.alloca_once_value(builder, start)
    return packed(context, builder, _COUNTER, [here, *others])


@lower_builtin("iternext", _Counter)
def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    place, stop, step = unpacked(builder, arguments[0])
    here = builder.load(place)
    up = builder.icmp_signed(">", step, INT64(0))
    more = builder.select(up, builder.icmp_signed("<", here, stop), builder.icmp_signed(">", here, stop))
    builder.store(builder.add(here, step, flags=["nsw"]), place)
    result = cgutils.create_struct_proxy(signature.return_type)(context, builder)
    result.first, result.second = here, more
    return result._getvalue()  # noqa: SLF001 - which is how Numba's own documentation has it


def _is_number(of: Any) -> bool:
    """Whether a float64 or an int64 holds it: not a uint64, which Python would compare as it is."""
    return isinstance(of, types.Float) or (isinstance(of, types.Integer) and (of.signed or of.bitwidth < 64))


def _type_of_choice(a: Any, b: Any) -> Any:
    if not _is_number(a) or not _is_number(b):
        return None
    both = types.float64 if isinstance(a, types.Float) or isinstance(b, types.Float) else types.int64
    return both(both, both)


def _choice(symbol: str) -> Emitter:
    """The second of two numbers where it is less, or greater, and else the first: as Python does, which shows with
    zeros and NaN.
    """

    def emit(_context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        a, b = arguments
        compare = builder.fcmp_ordered if signature.return_type == types.float64 else builder.icmp_signed
        return builder.select(compare(symbol, b, a), b, a)

    return emit


compiled_as(min_of, _type_of_choice, 2)(_choice("<"))
compiled_as(max_of, _type_of_choice, 2)(_choice(">"))


def _type_of_int(value: Any) -> Any:
    return types.int64(value) if isinstance(value, types.Integer | types.Float | types.Boolean) else None


@compiled_as(int_of, _type_of_int, 1)
def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return whole_number(context, builder, arguments[0], signature.args[0])
