"""Arrays by their addresses, which compiled code uses in place of Numba's own arrays.

Numba passes an array as seven numbers or more, and tests each index for a negative value. An `ArrayAt` is the address
of a C-contiguous array's numbers, and its shape; indices and slices only count from the front. With these, LLVM gets
half as much code. In Python both are NumPy's arrays, and rules and phases accept both.
"""

import operator
from typing import Any

import numba.core.types
from numba.core import cgutils
from numba.extending import lower_builtin, make_attribute_wrapper, models, register_model
from numpy.typing import NDArray

from catch_arena.core.extending import compiled_as

types: Any = numba.core.types  # Numba annotates only a part of it, without the names used here

# ---- for Python ----


def by_address(array: NDArray[Any]) -> NDArray[Any]:
    """Return the array of an entry, which must be C-contiguous, as the `ArrayAt` that phases take."""
    return array


def flat(array: NDArray[Any]) -> NDArray[Any]:
    """Return all numbers of an array in one dimension."""
    return array.reshape(-1)


# ---- for the compiler ----


class ArrayAt(types.Type):  # type: ignore[misc]
    """Compiler type of an array of numbers of one type, with `ndim` dimensions."""

    def __init__(self, dtype: Any, ndim: int) -> None:
        self.dtype, self.ndim = dtype, ndim
        super().__init__(f"ArrayAt({dtype} x {ndim})")


@register_model(ArrayAt)
class _ArrayAtModel(models.StructModel):
    def __init__(self, manager: Any, of: ArrayAt) -> None:
        shape = types.UniTuple(types.int64, of.ndim)
        super().__init__(manager, of, [("first", types.CPointer(of.dtype)), ("shape", shape)])


make_attribute_wrapper(ArrayAt, "shape", "shape")


def array_at(builder: Any, first: Any, shape: list[Any]) -> Any:
    """Return an `ArrayAt`, made of the pointer to its first number and its extents."""
    return cgutils.pack_struct(builder, [first, cgutils.pack_array(builder, shape)])


def parts_of(builder: Any, array: Any) -> tuple[Any, list[Any]]:
    """Return the pointer and the extents of an `ArrayAt`."""
    first, shape = cgutils.unpack_tuple(builder, array)
    return first, cgutils.unpack_tuple(builder, shape)


def product(builder: Any, numbers: list[Any]) -> Any:
    """Return the product of one or more numbers."""
    result, *others = numbers
    for number in others:
        result = builder.mul(result, number)
    return result


def _least(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.icmp_signed("<", a, b), a, b)


def _find(context: Any, builder: Any, array: Any, indices: list[Any]) -> Any:
    """Return the pointer to the numbers at these indices; there may be fewer indices than dimensions."""
    first, shape = parts_of(builder, array)
    offset = indices[0].type(0)
    for axis, extent in enumerate(shape):
        if axis > 0:
            offset = builder.mul(offset, extent)
        if axis < len(indices):
            if context.enable_boundscheck:
                cgutils.do_boundscheck(context, builder, indices[axis], extent, axis)
            offset = builder.add(offset, indices[axis])
    return builder.gep(first, [offset])


def _indices(context: Any, builder: Any, index: Any, of: Any) -> list[Any]:
    """Return an index, or those in a tuple, as int64."""
    kinds, values = [of], [index]
    if isinstance(of, types.BaseTuple):
        kinds, values = list(of), cgutils.unpack_tuple(builder, index, len(of))
    return [
        context.cast(builder, value, types.unliteral(kind), types.int64)
        for value, kind in zip(values, kinds, strict=True)
    ]


def _indexes(index: Any) -> int:
    """Return the number of dimensions of an index; 0 for anything that is not an index."""
    values = list(index) if isinstance(index, types.BaseTuple) else [index]
    return len(values) if all(isinstance(one, types.Integer) for one in values) else 0


def _type_of_item(array: Any, index: Any) -> Any:
    if not isinstance(array, ArrayAt):
        return None
    if isinstance(index, types.SliceType):
        return None if index.has_step else array(array, index)
    if _indexes(index) == array.ndim:
        return array.dtype(array, index)
    return ArrayAt(array.dtype, array.ndim - 1)(array, index) if _indexes(index) == 1 else None


@lower_builtin(operator.getitem, ArrayAt, types.BaseTuple)
@compiled_as(operator.getitem, _type_of_item, 2, ArrayAt, types.Integer)
def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    (array, index), (of, of_index) = arguments, signature.args
    found = _find(context, builder, array, _indices(context, builder, index, of_index))
    if isinstance(signature.return_type, ArrayAt):
        return array_at(builder, found, parts_of(builder, array)[1][1:])
    return context.unpack_value(builder, of.dtype, found)


@lower_builtin(operator.getitem, ArrayAt, types.SliceType)
def _(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
    array, bounds = arguments
    begin, end, _ = cgutils.unpack_tuple(builder, bounds)
    first, (extent, *inner) = parts_of(builder, array)
    end = _least(builder, end, extent)  # an omitted bound is the largest number
    begin = _least(builder, begin, end)
    if context.enable_boundscheck:  # a bound counted from the back would lie before the front
        cgutils.do_boundscheck(context, builder, begin, builder.add(extent, extent.type(1)), 0)
    first = builder.gep(first, [product(builder, [begin, *inner])])
    return array_at(builder, first, [builder.sub(end, begin), *inner])


def _type_of_put(array: Any, index: Any, _value: Any) -> Any:
    if isinstance(array, ArrayAt) and _indexes(index) == array.ndim:
        return types.void(array, index, array.dtype)
    return None


@lower_builtin(operator.setitem, ArrayAt, types.BaseTuple, types.Any)
@compiled_as(operator.setitem, _type_of_put, 3, ArrayAt, types.Integer, types.Any)
def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    (array, index, value), (of, of_index, of_value) = arguments, signature.args
    found = _find(context, builder, array, _indices(context, builder, index, of_index))
    context.pack_value(builder, of.dtype, context.cast(builder, value, of_value, of.dtype), found)
    return context.get_dummy_value()


@compiled_as(len, lambda array: types.intp(array) if isinstance(array, ArrayAt) else None, 1, ArrayAt)
def _(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
    return parts_of(builder, arguments[0])[1][0]


@compiled_as(by_address, lambda array: ArrayAt(array.dtype, array.ndim)(array) if array.layout == "C" else None, 1)
def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    array = context.make_array(signature.args[0])(context, builder, arguments[0])
    return array_at(builder, array.data, cgutils.unpack_tuple(builder, array.shape))


@compiled_as(flat, lambda array: ArrayAt(array.dtype, 1)(array) if isinstance(array, ArrayAt) else None, 1)
def _(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
    first, shape = parts_of(builder, arguments[0])
    return array_at(builder, first, [product(builder, shape)])
