"""Encoding of whole numbers as bytes that compress well: column by column, and byte plane by byte plane."""

import json
import struct
from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.errors import ReplayError

LENGTH: Final = struct.Struct("<I")
"""Length or number of items, which precedes them: four bytes, unsigned, little-endian."""
_WIDEST: Final = 8


def pack_json(value: object) -> bytes:
    """Return a value as JSON text, preceded by its length [bytes]."""
    text = json.dumps(value, separators=(",", ":")).encode()
    return LENGTH.pack(len(text)) + text


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


class Reader:
    """Reader of packed columns, JSON texts and plain bytes, from the beginning of a body to its end.

    Each method raises a ReplayError if the body holds something else.
    """

    def __init__(self, body: bytes) -> None:
        self._body = memoryview(body)
        self._at = 0

    def take(self, size: int) -> bytes:
        """Return the next `size` bytes."""
        if size > len(self._body) - self._at:
            raise ReplayError(f"is damaged: its body ends after {len(self._body)} bytes, before the end of its parts")
        self._at += size
        return bytes(self._body[self._at - size : self._at])

    def length(self) -> int:
        """Return the next length or count, a number of four bytes."""
        (number,) = LENGTH.unpack(self.take(LENGTH.size))
        return int(number)

    def json(self, part: str, longest: int) -> Any:
        """Return the value of the next JSON text, of at most `longest` bytes; `part` names it in errors."""
        length = self.length()
        if length > longest:
            raise ReplayError(f"is damaged: its {part} is {length} bytes long, more than {longest}")
        try:
            return json.loads(self.take(length).decode())
        except (ValueError, RecursionError):
            raise ReplayError(f"is damaged: it has no readable {part}") from None

    def columns(self, count: int, size: int) -> NDArray[np.int64]:
        """Return the next `count` columns as a table: (size, count)."""
        read = np.zeros((size, count), dtype=np.int64)
        for index in range(count):
            read[:, index] = self._column(size)
        return read

    def _column(self, size: int) -> NDArray[np.int64]:
        (width,) = self.take(1)
        if width > _WIDEST:
            raise ReplayError(f"is damaged: a column is {width} bytes wide")
        planes = np.zeros((_WIDEST, size), dtype=np.uint8)
        planes[:width] = np.frombuffer(self.take(width * size), dtype=np.uint8).reshape(width, size)
        folded = np.ascontiguousarray(planes.T).view("<u8").reshape(size)
        return (folded >> np.uint64(1)).astype(np.int64) ^ -(folded & np.uint64(1)).astype(np.int64)

    def end(self) -> None:
        """Require that all bytes have been read."""
        if left := len(self._body) - self._at:
            raise ReplayError(f"is damaged: {left} bytes follow its end")
