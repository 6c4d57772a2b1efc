"""Every form in which an agent may mean rank 1, and forms that mean no rank; an agent that returns one of them."""

import enum
from decimal import Decimal
from fractions import Fraction

import numpy as np


class Index:
    def __init__(self, number):
        self.number = number

    def __index__(self):
        return self.number


class Listed:
    """Stand-in for a tensor on a graphics card: it has `tolist`, and cannot become an array."""

    def __init__(self, content, dtype=None):
        self.content = np.array(content, dtype)

    def tolist(self):
        return self.content.tolist()

    def __array__(self, dtype=None, copy=None):
        raise TypeError("can't convert to numpy: use .cpu() first")


class Arrayed:
    """Stand-in for a tensor of a library without `tolist`."""

    def __init__(self, content):
        self.content = np.array(content)

    def __array__(self, dtype=None, copy=None):
        return self.content


class Broken(Listed):
    def tolist(self):
        raise RuntimeError("no data")

    __index__ = tolist


class Rank(enum.IntEnum):
    FIRST = 1


RANK_1 = {
    "int": 1,
    "enum": Rank.FIRST,
    "index": Index(1),
    "int64": np.int64(1),
    "uint8": np.uint8(1),
    "array without axes": np.array(1),
    "array": np.array([1]),
    "array with two axes": np.array([[1]], np.int8),
    "array of objects": np.array([1], object),
    "tensor": Listed([1]),
    "tensor without axes": Listed(1),
    "array-like": Arrayed([1]),
}
NO_RANK = {
    "text": "1",
    "bytes": b"1",
    "None": None,
    "float": 1.0,
    "half": 1.5,
    "nan": float("nan"),
    "float32": np.float32(1),
    "fraction": Fraction(1),
    "decimal": Decimal(1),
    "True": True,
    "False": False,
    "bool_": np.True_,
    "text of a boolean": "true",
    "list": [1],
    "tuple": (1,),
    "dict": {"catch": 1},
    "class": np.ndarray,
    "object": object(),
    "empty array": np.array([], int),
    "longer array": np.array([1, 1]),
    "array of floats": np.array([1.0]),
    "array of booleans": np.array([True]),
    "boolean without axes": np.array(True),
    "array of text": np.array(["1"]),
    "empty tensor": Listed([], int),
    "longer tensor": Listed([1, 1]),
    "tensor of floats": Listed([1.0]),
    "tensor of booleans": Listed([True]),
    "broken tensor": Broken([1]),
    "too high": 9,
    "too low": np.int64(-1),
    "huge": 10**30,
}
FORMS = [*RANK_1.values(), *NO_RANK.values()]


class Agent:
    """Agent that returns the form with the number of its seed."""

    def reset(self, seed):
        self.form = FORMS[seed]

    def act(self, _view):
        return self.form
