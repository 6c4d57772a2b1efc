"""Python's own numbers and lists, from whatever stands for them: NumPy's, a tensor's, a ctypes integer's."""

import numbers
import operator
from collections.abc import Mapping, Sequence
from typing import Any


def whole_number(value: Any) -> int | None:
    """Return what `operator.index` takes as an int; None for all else, booleans too."""
    if isinstance(value, bool):
        return None
    try:
        return operator.index(value)
    except Exception:  # noqa: BLE001 - a stranger's object may raise anything
        return None


def real_number(value: object) -> int | float | None:
    """Return a `numbers.Real` as an int or a float; None for all else, booleans too."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        return None
    return int(value) if isinstance(value, numbers.Integral) else float(value)


def as_python(value: Any) -> Any:
    """Return the number or the nested lists that stand for a number, an array or a tensor; all else as it is."""
    try:
        if callable(getattr(value, "tolist", None)):
            value = value.tolist()
        elif callable(getattr(value, "__array__", None)):
            value = value.__array__().tolist()
    except Exception:  # noqa: BLE001 - a stranger's object may raise anything
        return value
    number: int | float | None = whole_number(value)
    if number is None:
        number = real_number(value)
    return value if number is None else number


def plain_setting(value: Any) -> Any:
    """Return a setting with Python's own numbers, and tuples for arrays, lists and other sequences."""
    plain = as_python(value)
    if isinstance(plain, Sequence) and not isinstance(plain, str | bytes):
        return tuple(map(plain_setting, plain))
    return plain


def plain_action(action: Any) -> Any:
    """Return an action as Python's own numbers, lists and dicts; an array with one element as that element.

    The one rule of what an action may be, in the environments and for agents in any process.
    """
    if isinstance(action, Mapping):
        return {name: _plain_part(part) for name, part in action.items()}
    return _plain_part(action)


def _plain_part(part: Any) -> Any:
    plain = as_python(part)
    element = plain
    while isinstance(element, list) and len(element) == 1:
        (element,) = element
    return plain if isinstance(part, list) or isinstance(element, list) else element
