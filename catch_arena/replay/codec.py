"""Encoding of whole numbers as bytes that compress well: column by column, and byte plane by byte plane."""

import json
import struct
from collections.abc import Iterable
from io import BytesIO
from typing import Final, TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from catch_arena.errors import ReplayError

NUMBER: Final = struct.Struct("<I")
"""Length or number of items, which precedes them: four bytes, unsigned, little-endian."""
_WIDEST: Final = 8
_T = TypeVar("_T")


def pack_json(value: object) -> bytes:
    """Return a value as JSON text, preceded by its length [bytes]."""
    text = json.dumps(value, separators=(",", ":")).encode()
    return NUMBER.pack(len(text)) + text


def pack_columns(columns: Iterable[NDArray[np.int64]]) -> bytes:
    """Return each column as its width in bytes, 0 to 8, and one plane for each byte: the lowest bytes of all numbers,
    the next ones, and so on. The sign becomes the lowest bit: 0, -1, 1, -2 become 0, 1, 2, 3.
    """
    parts: list[bytes] = []
    for column in columns:
        folded = ((column << 1) ^ (column >> 63)).astype("<u8")
        width = (int(folded.max(initial=0)).bit_length() + 7) // 8
        planes = np.ascontiguousarray(folded).view(np.uint8).reshape(-1, _WIDEST).T[:width]
        parts += [bytes([width]), planes.tobytes()]
    return b"".join(parts)


def read_number(body: BytesIO) -> int:
    """Return the next length or count, a number of four bytes."""
    return int.from_bytes(body.read(NUMBER.size), "little")


def read_json(body: BytesIO, longest: int, kind: type[_T]) -> _T:
    """Return the value of the next JSON text; raise ReplayError if it is longer than `longest` bytes."""
    length = read_number(body)
    if length > longest:
        raise ReplayError(f"is damaged: a JSON text is {length} bytes long, more than {longest}")
    return msgspec.convert(json.loads(body.read(length)), kind)


def read_columns(body: BytesIO, count: int, size: int) -> NDArray[np.int64]:
    """Return the next `count` columns as a table: (size, count)."""
    table = np.zeros((size, count), dtype=np.int64)
    for index in range(count):
        (width,) = body.read(1)
        planes = np.zeros((_WIDEST, size), dtype=np.uint8)
        planes[:width] = np.frombuffer(body.read(width * size), dtype=np.uint8).reshape(width, size)
        folded = np.ascontiguousarray(planes.T).view("<u8").reshape(size)
        table[:, index] = (folded >> np.uint64(1)).astype(np.int64) ^ -(folded & np.uint64(1)).astype(np.int64)
    return table
