"""BLAKE2b after RFC 7693, in plain Python, with the parameters of BLAKE2's own paper: key and `person`."""

import struct

WORD = (1 << 64) - 1
START = (
    0x6A09E667F3BCC908, 0xBB67AE8584CAA73B, 0x3C6EF372FE94F82B, 0xA54FF53A5F1D36F1,
    0x510E527FADE682D1, 0x9B05688C2B3E6C1F, 0x1F83D9ABFB41BD6B, 0x5BE0CD19137E2179,
)  # fmt: skip
ORDERS = (
    (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
    (14, 10, 4, 8, 9, 15, 13, 6, 1, 12, 0, 2, 11, 7, 5, 3),
    (11, 8, 12, 0, 5, 2, 15, 13, 10, 14, 3, 6, 7, 1, 9, 4),
    (7, 9, 3, 1, 13, 12, 11, 14, 2, 6, 5, 10, 4, 0, 15, 8),
    (9, 0, 5, 7, 2, 4, 10, 15, 14, 1, 11, 12, 6, 8, 3, 13),
    (2, 12, 6, 10, 0, 11, 8, 3, 4, 13, 7, 5, 15, 14, 1, 9),
    (12, 5, 1, 15, 14, 13, 4, 10, 0, 7, 6, 3, 9, 2, 8, 11),
    (13, 11, 7, 14, 12, 1, 3, 9, 5, 0, 15, 4, 8, 6, 2, 10),
    (6, 15, 14, 9, 11, 3, 0, 8, 12, 2, 13, 7, 1, 4, 10, 5),
    (10, 2, 8, 4, 7, 6, 1, 5, 15, 11, 9, 14, 3, 12, 13, 0),
)
MIXED = (
    (0, 4, 8, 12), (1, 5, 9, 13), (2, 6, 10, 14), (3, 7, 11, 15),
    (0, 5, 10, 15), (1, 6, 11, 12), (2, 7, 8, 13), (3, 4, 9, 14),
)  # fmt: skip


def blake2b(message: bytes, size: int, key: bytes = b"", person: bytes = b"") -> bytes:
    """The digest of `size` bytes."""
    parameters = struct.pack("<BBBBIQBB14x16s16s", size, len(key), 1, 1, 0, 0, 0, 0, b"", person)
    state = [start ^ word for start, word in zip(START, struct.unpack("<8Q", parameters), strict=True)]
    text = (key.ljust(128, b"\0") if key else b"") + message
    blocks = [text[at : at + 128] for at in range(0, len(text), 128)] or [b""]
    hashed = 0
    for number, block in enumerate(blocks, 1):
        hashed += len(block)
        state = _compressed(state, struct.unpack("<16Q", block.ljust(128, b"\0")), hashed, last=number == len(blocks))
    return struct.pack("<8Q", *state)[:size]


def _compressed(state: list[int], words: tuple[int, ...], hashed: int, *, last: bool) -> list[int]:
    v = [*state, *START]
    v[12] ^= hashed & WORD
    v[13] ^= hashed >> 64
    if last:
        v[14] ^= WORD
    for turn in range(12):
        order = ORDERS[turn % 10]
        for which, (a, b, c, d) in enumerate(MIXED):
            for word, one, other in ((words[order[2 * which]], 32, 24), (words[order[2 * which + 1]], 16, 63)):
                v[a] = (v[a] + v[b] + word) & WORD
                v[d] = _rotated(v[d] ^ v[a], one)
                v[c] = (v[c] + v[d]) & WORD
                v[b] = _rotated(v[b] ^ v[c], other)
    return [one ^ low ^ high for one, low, high in zip(state, v[:8], v[8:], strict=True)]


def _rotated(word: int, by: int) -> int:
    return (word >> by | word << (64 - by)) & WORD
