"""Equality of objects that hold arrays, on which `==` of tuples and dataclasses fails."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np


class EqualByBits:
    """Base of dataclasses with arrays, which are equal if every bit of every field is equal."""

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        names = [field.name for field in dataclasses.fields(self)]  # type: ignore[arg-type]
        return type(self) is type(other) and all(_equal(getattr(self, name), getattr(other, name)) for name in names)


def _equal(one: Any, other: Any) -> bool:
    """Return whether two values are equal: arrays in every bit, mappings and sequences item by item, others by `==`."""
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(_equal(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(_equal, one, other))
    return type(one) is type(other) and bool(one == other)
