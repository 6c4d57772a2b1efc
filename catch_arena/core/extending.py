"""Registration of our own functions with the compiler, over Numba's extension interface."""

from collections.abc import Callable
from typing import Any, Final, cast

from llvmlite import ir
from numba import types
from numba.extending import lower_builtin, type_callable

Emitter = Callable[..., Any]

INT32: Final = ir.IntType(32)
INT64: Final = ir.IntType(64)


def compiled_as(
    function: Callable[..., Any], typer: Callable[..., Any], arity: int, *formal: Any
) -> Callable[[Emitter], Emitter]:
    """Return a decorator that registers the code of a function: `typer` gives its signature, or None for types that it
    does not take; the decorated emitter makes its code.
    """
    type_callable(function)(lambda _context: typer)
    return cast("Callable[[Emitter], Emitter]", lower_builtin(function, *(formal or (types.Any,) * arity)))
