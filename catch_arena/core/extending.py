"""Registration of our own functions and types with the compiler, over Numba's extension interface."""

from collections.abc import Callable, Sequence
from typing import Any, Final, cast

from llvmlite import ir
from numba import types
from numba.core.typing import templates
from numba.extending import infer_getattr, lower_builtin, lower_getattr_generic, type_callable

Typer = Callable[..., Any]
Emitter = Callable[..., Any]

_Fields: Any = templates.AttributeTemplate  # the base of what `infer_getattr` takes
INT32: Final = ir.IntType(32)
INT64: Final = ir.IntType(64)


def compiled_as(function: Callable[..., Any], typer: Typer, arity: int, *formal: Any) -> Callable[[Emitter], Emitter]:
    """Return a decorator that registers the code of a function: `typer` gives its signature, or None for types that it
    does not take; the decorated emitter makes its code.
    """
    type_callable(function)(lambda _context: typer)
    return cast("Callable[[Emitter], Emitter]", lower_builtin(function, *(formal or (types.Any,) * arity)))


def fields_as(of: Any, type_of: Typer) -> Callable[[Emitter], Emitter]:
    """Return a decorator that registers the fields of a type: `type_of` a type and a name gives the field's type, or
    None if there is no such field; the decorated emitter makes the code that reads it.
    """

    class Fields(_Fields):  # type: ignore[misc]
        key = of

        def generic_resolve(self, one: Any, name: str) -> Any:
            return type_of(one, name)

    infer_getattr(Fields)
    return cast("Callable[[Emitter], Emitter]", lower_getattr_generic(of))


def packed(context: Any, builder: Any, of: Any, members: Sequence[Any]) -> Any:
    """Return a value of a compound type, made of its members."""
    whole = ir.Constant(context.get_value_type(of), ir.Undefined)
    for place, member in enumerate(members):
        whole = builder.insert_value(whole, member, place)
    return whole


def unpacked(builder: Any, whole: Any) -> list[Any]:
    """Return the members of a value that `packed` has made."""
    return [builder.extract_value(whole, place) for place in range(len(whole.type.elements))]


def constant_at(builder: Any, pointer: Any) -> Any:
    """Return the value at a pointer. No code compiled together with this writes it, so that LLVM reads it once."""
    value = builder.load(pointer)
    value.set_metadata("invariant.load", builder.module.add_metadata([]))
    return value


def whole_number(context: Any, builder: Any, value: Any, of: Any) -> Any:
    """Return a bound or an index, as an int64."""
    return context.cast(builder, value, types.unliteral(of), types.int64)
