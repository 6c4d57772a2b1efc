"""A plain decoder of replay files, written from docs/reference/replays.md and the rulebook's appendix alone."""

import hashlib
import json
import struct
import zlib
from typing import Any


class Body:
    def __init__(self, data: bytes):
        self.data = data
        self.at = 0

    def bytes(self, count: int) -> bytes:
        taken = self.data[self.at : self.at + count]
        assert len(taken) == count
        self.at += count
        return taken

    def column(self, count: int) -> list[int]:
        width = self.bytes(1)[0]
        planes = [self.bytes(count) for _ in range(width)]
        folded = [sum(plane[i] << (8 * place) for place, plane in enumerate(planes)) for i in range(count)]
        return [-(number + 1) // 2 if number % 2 else number // 2 for number in folded]


def decode(content: bytes) -> dict[str, Any]:
    """The header's entries, and `ranks`, `commands`, `prey_commands` and `digests`, by step."""
    assert content[:8] == bytes.fromhex("894341544348 0D0A")
    form, length = struct.unpack("<IQ", content[8:20])
    assert form == 6
    assert len(content) == 20 + length + 32
    assert hashlib.blake2b(content[:-32], digest_size=32).digest() == content[-32:]
    body = Body(zlib.decompress(content[20:-32]))
    header = json.loads(body.bytes(struct.unpack("<I", body.bytes(4))[0]).decode("utf-8"))
    config, steps = header["config"], header["steps"]
    hunters = config["hunters"]
    controls = [config["control"]] * hunters if isinstance(config["control"], str) else config["control"]
    ranks = [body.column(steps) for _ in range(hunters)]
    commands = {
        seat: [[float32(word) for word in body.column(steps)] for _ in range(2)]
        for seat in range(hunters)
        if controls[seat] != "target"
    }
    many = config.get("prey", 0)
    prey_commands = [[[float32(word) for word in body.column(steps)] for _ in range(2)] for _ in range(many)]
    requests = named_requests(body)
    digests = [body.bytes(8) for _ in range(steps + 1)]
    assert body.at == len(body.data)
    return {
        **header,
        "ranks": ranks,
        "commands": commands,
        "prey_commands": prey_commands,
        "named_requests": requests,
        "digests": digests,
    }


def named_requests(body: Body) -> list[tuple[int, int, str | None]]:
    """(steps before, seat, name) of each."""
    names = json.loads(body.bytes(struct.unpack("<I", body.bytes(4))[0]).decode("utf-8"))
    (count,) = struct.unpack("<I", body.bytes(4))
    later, seats, places = (body.column(count) for _ in range(3))
    return [(step, seat, names[place]) for step, seat, place in zip(summed(later), seats, places, strict=True)]


def float32(rotated: int) -> float:
    word = (rotated >> 1) | ((rotated & 1) << 31)
    return struct.unpack("<f", struct.pack("<I", word))[0]


def summed(rest: list[int]) -> list[int]:
    total, found = 0, []
    for number in rest:
        total += number
        found.append(total)
    return found
