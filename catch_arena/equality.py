"""Equality of objects that hold arrays, on which `==` of tuples and dataclasses fails."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np


def equal(one: Any, other: Any) -> bool:
    """Return whether two values are equal: arrays in every bit, mappings and sequences item by item, others by `==`."""
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(equal(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(equal, one, other))
    return type(one) is type(other) and bool(one == other)


def equal_fields(one: Any, other: object) -> bool:
    """Return whether two objects of one dataclass are equal field by field; the `__eq__` of dataclasses with arrays."""
    names = [field.name for field in dataclasses.fields(one)]
    return type(one) is type(other) and all(equal(getattr(one, name), getattr(other, name)) for name in names)
