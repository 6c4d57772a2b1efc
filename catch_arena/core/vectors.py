"""Vectors of several arenas: `row[X + lane]`, for a group of lanes `lane`, is one vector of numbers.

Rules and phases are written for one lane. `group` decides the meaning of `lane`. With a width of one it is a plain
index, and everything is a plain number. With a larger width it is that index and the next ones, and reading with it
gives a vector. On vectors `+ - * /`, comparisons, `&`, `|` and the functions below work number by number, with the
same bits. In compiled code a vector is one of the processor's, and stays in registers. In interpreted code it is a
NumPy array. Do not use `+=`: it would change an array under all its names.

The functions below are those that a rule needs besides operators: `select` in place of `a if condition else b`,
`floor`, `sqrt`, and a few for bits. Each is written twice: for Python, and, with Numba's extension interface, for the
compiler.
"""

import operator
from collections.abc import Callable, Sequence
from typing import Any, Final, TypeVar, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import lower_cast, models, register_model

from catch_arena.core.addresses import ArrayAt, parts_of
from catch_arena.core.extending import INT32, Emitter, compiled_as
from catch_arena.core.jit import rule
from catch_arena.core.modes import COMPILER

LANES: Final = 32
"""Number of arenas side by side in a chunk: enough for the widest SIMD registers, few enough for the first caches."""

Width = tuple[int, ...]
"""Number of lanes in a group: the length of the tuple, which the compiler knows."""
SINGLE: Final[Width] = (0,)
HALF: Final[Width] = (0,) * 4
WIDE: Final[Width] = (0,) * 8
"""Width of an AVX2 register of float32, which holds eight numbers; one of float64 holds four, as HALF."""
PLAYED: Final = WIDE if COMPILER and COMPILER.HAS_AVX512VL else HALF
"""Number of lanes of a batch that play together. AVX-512VL has 32 registers, enough for eight float64 in two each; AVX2
has 16, with which such code would keep numbers in memory.
"""

T = TypeVar("T")


@rule
def played_lanes(width: Width) -> int:
    """Return the number of a chunk's lanes that are played: one if there is one arena. Lanes after a batch's last arena
    are played too, and not read: to leave them out would mostly cost more than to play them.
    """
    return LANES if len(width) > 1 else 1


# ---- for Python ----


def group(first: int, width: Width) -> int:
    """Return the lanes from `first` on, as many as the width has."""
    return first if len(width) == 1 else cast("int", np.arange(first, first + len(width)))


def select(condition: bool, a: T, b: T) -> T:
    """Return `a if condition else b`, in each lane."""
    if isinstance(condition, np.ndarray):
        return cast("T", np.where(condition, a, b))
    return a if condition else b


def any_of(condition: bool) -> bool:
    """Return whether a condition holds in any lane of a group."""
    return bool(condition.any() if isinstance(condition, np.ndarray) else condition)


def floor(value: float) -> float:
    """Return the greatest whole number not above a value, as a float: Python's own function makes an int."""
    return cast("float", np.floor(value))


def sqrt(value: float) -> float:
    """Return the square root, rounded to nearest."""
    return cast("float", np.sqrt(value))


def single_bits(value: float) -> int:
    """Return the bits of a number rounded to float32, as an int32. If none is negative, they sort as the numbers do."""
    return cast("int", np.float32(value).view(np.int32))


def truncate(value: float) -> int:
    """Return a number from 0 to 2^31 - 1 without its fraction, as an int32."""
    return cast("int", np.asarray(value).astype(np.int32)[()])


def byte(value: int) -> int:
    """Return an int32 from 0 to 127 as an int8."""
    return cast("int", np.asarray(value).astype(np.int8)[()])


def long(value: int) -> int:
    """Return an int8 or an int32 as an int64."""
    return cast("int", np.asarray(value).astype(np.int64)[()])


# ---- for the compiler ----


class Vector(types.Type):
    """Compiler type of `count` numbers of one type."""

    def __init__(self, dtype: Any, count: int) -> None:
        self.dtype, self.count = dtype, count
        super().__init__(f"Vector({dtype} x {count})")

    def can_convert_from(self, context: Any, other: Any) -> Any:
        """Let a number become a vector that has it in every lane, as safely as an int64 becomes a float64."""
        is_number = isinstance(other, types.Number | types.Boolean)
        return context.can_convert(types.int64, types.float64) if is_number else None


class Lanes(types.Type):
    """Compiler type of an index that stands for `count` lanes, given by the first."""

    def __init__(self, count: int) -> None:
        self.count = count
        super().__init__(f"Lanes({count})")


_LOW_LEVEL: Final = {
    types.float64: ir.DoubleType(),
    types.float32: ir.FloatType(),
    types.int64: ir.IntType(64),
    types.int32: INT32,
    types.int8: ir.IntType(8),
    types.boolean: ir.IntType(1),
}


def low_level(of: Any) -> Any:
    """Return LLVM's type of a number or vector in registers."""
    return ir.VectorType(_LOW_LEVEL[of.dtype], of.count) if isinstance(of, Vector) else _LOW_LEVEL[of]


def like(of: Any, dtype: Any) -> Any:
    """Return a type with as many numbers as `of`, of another type."""
    return Vector(dtype, of.count) if isinstance(of, Vector) else dtype


@register_model(Vector)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager: Any, of: Vector) -> None:
        super().__init__(manager, of, low_level(of))


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, of: Lanes) -> None:
        super().__init__(manager, of, ir.IntType(64))


@lower_cast(types.Number, Vector)
@lower_cast(types.Boolean, Vector)
def _spread(context: Any, builder: Any, number: Any, vector: Vector, value: Any) -> Any:
    """Return a vector with the same number in every lane."""
    value = context.cast(builder, value, types.unliteral(number), vector.dtype)
    empty = ir.Constant(low_level(vector), ir.Undefined)
    first = builder.insert_element(empty, value, INT32(0))
    return shuffle(builder, first, empty, [0] * vector.count)


@lower_cast(Vector, Vector)
def _round(_context: Any, builder: Any, given: Vector, made: Vector, value: Any) -> Any:
    """Return the numbers rounded to float32, if they have another type."""
    return value if given == made else builder.fptrunc(value, low_level(made))


def shuffle(builder: Any, a: Any, b: Any, chosen: list[int]) -> Any:
    """Return a vector of chosen lanes: those of `a` count from 0, and those of `b` follow."""
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(INT32, len(chosen)), chosen))


def _common(a: Any, b: Any) -> Any:
    """Return the vector type to which both convert, if one is a vector type and the other can convert; else None."""
    vector, other = (a, b) if isinstance(a, Vector) else (b, a)
    converts = other == vector or isinstance(other, types.Number | types.Boolean)
    return vector if isinstance(vector, Vector) and converts else None


def _operate(symbol: Callable[..., Any], emit: Emitter, *, compares: bool = False) -> None:
    """Let an operator work on vectors. `emit` gets a builder, the numbers' type and both sides."""

    def typer(a: Any, b: Any) -> Any:
        both = _common(a, b)
        return None if both is None else (like(both, types.boolean) if compares else both)(both, both)

    @compiled_as(symbol, typer, 2, Vector, Vector)
    def _(_context: Any, builder: Any, signature: Any, both: Any) -> Any:
        return emit(builder, signature.args[0].dtype, *both)


def _arithmetic(floats: str, integers: str) -> Emitter:
    return lambda builder, dtype, a, b: getattr(builder, floats if dtype in types.real_domain else integers)(a, b)


def _comparison(symbol: str) -> Emitter:
    def emit(builder: Any, dtype: Any, a: Any, b: Any) -> Any:
        if dtype not in types.real_domain:
            return builder.icmp_signed(symbol, a, b)
        return (builder.fcmp_unordered if symbol == "!=" else builder.fcmp_ordered)(symbol, a, b)

    return emit


for _symbol, _floats, _integers in (
    (operator.add, "fadd", "add"),
    (operator.sub, "fsub", "sub"),
    (operator.mul, "fmul", "mul"),
    (operator.truediv, "fdiv", ""),
    (operator.and_, "", "and_"),
    (operator.or_, "", "or_"),
):
    _operate(_symbol, _arithmetic(_floats, _integers))
for _symbol, _written in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
    (operator.ne, "!="),
):
    _operate(_symbol, _comparison(_written), compares=True)


@compiled_as(operator.neg, lambda a: a(a) if isinstance(a, Vector) else None, 1, Vector)
def _(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
    return builder.fneg(*arguments)


# lanes as indices


def _type_of_lanes_added(a: Any, b: Any) -> Any:
    return b(types.int64, b) if isinstance(a, types.Integer) and isinstance(b, Lanes) else None


@compiled_as(operator.add, _type_of_lanes_added, 2, types.Integer, Lanes)
def _(_context: Any, builder: Any, _signature: Any, both: Any) -> Any:
    return builder.add(*both)


def pointer_to(context: Any, builder: Any, array: Any, first: Any, of: Any) -> Any:
    """Return a pointer to one or more numbers of an `ArrayAt`; `first` must not be negative."""
    data, (size,) = parts_of(builder, array)
    if context.enable_boundscheck:
        last = builder.add(first, first.type(of.count - 1 if isinstance(of, Vector) else 0))
        for index in (first, last):
            cgutils.do_boundscheck(context, builder, index, size)
    return builder.bitcast(builder.gep(data, [first]), low_level(of).as_pointer())


def _type_of_load(row: Any, lane: Any) -> Any:
    if isinstance(row, ArrayAt) and isinstance(lane, Lanes):
        return Vector(row.dtype, lane.count)(row, lane)
    return None


@compiled_as(operator.getitem, _type_of_load, 2, ArrayAt, Lanes)
def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    vector = signature.return_type
    row, lane = arguments
    pointer = pointer_to(context, builder, row, lane, vector)
    return builder.load(pointer, align=vector.dtype.bitwidth // 8)


def _type_of_store(row: Any, lane: Any, _value: Any) -> Any:
    if isinstance(row, ArrayAt) and isinstance(lane, Lanes):
        return types.void(row, lane, Vector(row.dtype, lane.count))
    return None


@compiled_as(operator.setitem, _type_of_store, 3, ArrayAt, Lanes, Vector)
def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    row, lane, value = arguments
    vector = signature.args[2]
    pointer = pointer_to(context, builder, row, lane, vector)
    builder.store(value, pointer, align=vector.dtype.bitwidth // 8)
    return context.get_dummy_value()


@compiled_as(group, lambda _, width: (Lanes(len(width)) if len(width) > 1 else types.int64)(types.int64, width), 2)
def _(_context: Any, _builder: Any, _signature: Any, arguments: Any) -> Any:
    return arguments[0]


# functions of numbers


def _type_of_select(condition: Any, a: Any, b: Any) -> Any:
    if isinstance(a, Vector) or isinstance(b, Vector):
        vector, by_lane = _common(a, b), isinstance(condition, Vector)
        return None if vector is None else vector(condition if by_lane else types.boolean, vector, vector)
    if isinstance(condition, Vector):
        vector = like(condition, types.float64)
        return vector(condition, vector, vector)
    number = types.float64 if isinstance(a, types.Float) or isinstance(b, types.Float) else types.unliteral(a)
    unequal = number != types.float64 and number != types.unliteral(b)  # True or 3: the type depends on the condition
    return None if unequal else number(types.boolean, number, number)


@compiled_as(select, _type_of_select, 3)
def _(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
    return builder.select(*arguments)


def _type_of_any(condition: Any) -> Any:
    return types.boolean(condition)


@compiled_as(any_of, _type_of_any, 1)
def _(_context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    (condition,) = signature.args
    if not isinstance(condition, Vector):
        return arguments[0]
    bits = ir.IntType(condition.count)
    return builder.icmp_unsigned("!=", builder.bitcast(arguments[0], bits), bits(0))


def _rounded_by(name: str) -> Emitter:
    """Return an emitter that calls LLVM's own function, for one number or for all lanes."""

    def emit(_context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        of = low_level(signature.return_type)
        kind = f"v{of.count}f64" if isinstance(of, ir.VectorType) else "f64"
        function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(of, [of]), f"llvm.{name}.{kind}")
        return builder.call(function, arguments)

    return emit


def _type_of_rounded(value: Any) -> Any:
    of = like(value, types.float64)
    return of(of)


for _function, _name in ((floor, "floor"), (sqrt, "sqrt")):
    compiled_as(_function, _type_of_rounded, 1)(_rounded_by(_name))


def _convert(function: Callable[..., Any], sources: Sequence[Any], dtype: Any, *instructions: tuple[str, Any]) -> None:
    """Compile a function as LLVM's instructions, one after the other, each with the type that it makes. Numbers of
    another type than its sources become the first of them.
    """

    def typer(value: Any) -> Any:
        own = value.dtype if isinstance(value, Vector) else value
        return like(value, dtype)(like(value, own if own in sources else sources[0]))

    @compiled_as(function, typer, 1)
    def _(_context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        (value,) = arguments
        for instruction, made in instructions:
            value = getattr(builder, instruction)(value, low_level(like(signature.return_type, made)))
        return value


_convert(single_bits, [types.float64], types.int32, ("fptrunc", types.float32), ("bitcast", types.int32))
_convert(truncate, [types.float64], types.int32, ("fptosi", types.int32))
_convert(byte, [types.int32], types.int8, ("trunc", types.int8))
_convert(long, [types.int32, types.int8], types.int64, ("sext", types.int64))
