"""Conversion of NumPy arrays, tensors, ctypes integers and similar values to Python's own numbers and lists."""

import numbers
import operator
from collections.abc import Mapping, Sequence
from typing import Any


def whole_number(value: Any) -> int | None:
    """Return a value that `operator.index` accepts as an int; None for other values, including booleans."""
    if isinstance(value, bool):
        return None
    try:
        return operator.index(value)
    except Exception:  # noqa: BLE001 - foreign objects may raise anything
        return None


def as_python(value: Any) -> Any:
    """Return a number, an array or a tensor as a Python number or nested lists; other values unchanged."""
    if value is None or type(value) in (int, float, bool, str):  # most settings, and most actions
        return value
    try:
        if callable(getattr(value, "tolist", None)):
            value = value.tolist()
        elif callable(getattr(value, "__array__", None)):
            value = value.__array__().tolist()
    except Exception:  # noqa: BLE001 - foreign objects may raise anything
        return value
    number = whole_number(value)
    if number is None and isinstance(value, numbers.Real) and not isinstance(value, bool):
        return float(value)
    return value if number is None else number


def real_number(value: object) -> int | float | None:
    """Return a number that `as_python` knows; None for other values, including booleans."""
    plain = as_python(value)
    return plain if type(plain) in (int, float) else None


def plain_setting(value: Any) -> Any:
    """Return a setting with Python's own numbers, and tuples for arrays, lists and other sequences."""
    plain = as_python(value)
    if isinstance(plain, Sequence) and not isinstance(plain, str | bytes):
        return tuple(map(plain_setting, plain))
    return plain


def plain_action(action: Any) -> Any:
    """Return an action as Python's own numbers, lists and dicts; an array with one element as that element.

    All environments and all agents' processes convert actions by this function.
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
