"""Whole numbers as bytes that compress well: column by column, and within a column plane by plane."""

import json
import struct
from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.errors import ReplayError

LENGTH: Final = struct.Struct("<I")
"""What stands before that whose length the file has to tell."""
_WIDEST: Final = 8
_ONE: Final = np.uint64(1)
_BYTE: Final = np.uint64(255)


def pack_columns(columns: Iterable[NDArray[np.int64]]) -> bytes:
    """Each column as a width in bytes, 0 to 8, and that many planes: the lowest bytes of all its numbers, the next
    ones, and so on. A sign stands in the lowest bit: 0, -1, 1, -2 become 0, 1, 2, 3.
    """
    parts: list[bytes] = []
    for column in columns:
        folded = ((column << 1) ^ (column >> 63)).astype(np.uint64)
        width = (int(folded.max(initial=0)).bit_length() + 7) // 8
        parts.append(bytes([width]))
        parts += [((folded >> np.uint64(8 * plane)) & _BYTE).astype(np.uint8).tobytes() for plane in range(width)]
    return b"".join(parts)


class Reader:
    """Reads what `pack_columns` wrote, and plain bytes, from one end of a body to the other."""

    def __init__(self, body: bytes) -> None:
        self._body = memoryview(body)
        self._at = 0

    def take(self, size: int) -> bytes:
        """The next bytes.

        Raises:
            ReplayError: where there are fewer.
        """
        if size > len(self._body) - self._at:
            raise ReplayError(f"is damaged: its body ends after {len(self._body)} bytes, and more are announced")
        self._at += size
        return bytes(self._body[self._at - size : self._at])

    def length(self) -> int:
        """The next four bytes, as `LENGTH` has them.

        Raises:
            ReplayError: where there are fewer.
        """
        (number,) = LENGTH.unpack(self.take(LENGTH.size))
        return int(number)

    def json(self, what: str, longest: int) -> Any:
        """The next JSON text, behind its length [bytes].

        Raises:
            ReplayError: that says what it should have been, for one that is longer, or that nobody can read.
        """
        length = self.length()
        if length > longest:
            raise ReplayError(f"is damaged: its {what} is {length} bytes long, more than {longest}")
        try:
            return json.loads(self.take(length).decode())
        except (ValueError, RecursionError):
            raise ReplayError(f"is damaged: it has no readable {what}") from None

    def column(self, size: int) -> NDArray[np.int64]:
        """The next column, of that many numbers.

        Raises:
            ReplayError: where it is no replay, or a damaged one.
        """
        (width,) = self.take(1)
        if width > _WIDEST:
            raise ReplayError(f"is damaged: a column is {width} bytes wide")
        folded = np.zeros(size, dtype=np.uint64)
        for plane in range(width):
            folded |= np.frombuffer(self.take(size), dtype=np.uint8).astype(np.uint64) << np.uint64(8 * plane)
        return (folded >> _ONE).astype(np.int64) ^ -(folded & _ONE).astype(np.int64)

    def columns(self, count: int, size: int) -> NDArray[np.int64]:
        """That many columns beside each other: (size, count).

        Raises:
            ReplayError: where it is no replay, or a damaged one.
        """
        read = np.zeros((size, count), dtype=np.int64)
        for index in range(count):
            read[:, index] = self.column(size)
        return read

    def end(self) -> None:
        """Require that all bytes have been read.

        Raises:
            ReplayError: where something is left.
        """
        if left := len(self._body) - self._at:
            raise ReplayError(f"is damaged: {left} bytes follow its end")
