"""A plain decoder of replay files, written from docs/reference/replays.md and the rulebook's appendix alone."""

import hashlib
import json
import math
import struct
import zlib
from typing import Any

from oracle.arithmetic import sincos

MILLION = 1000000
CLOCK, HUNTER, TARGET, MOTION, PREY = 8, 11, 5, 6, 3
LINEAR, ANGULAR, ACTIVE = 3, 4, 7


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
    """The header's entries, and `ranks`, `commands`, `prey_commands`, `digests` and `states`, by state or step."""
    assert content[:8] == bytes.fromhex("894341544348 0D0A")
    form, length = struct.unpack("<IQ", content[8:20])
    assert 2 <= form <= 5
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
    assert (form - 2) % 2 == (1 if many else 0)
    prey_commands = [[[float32(word) for word in body.column(steps)] for _ in range(2)] for _ in range(many)]
    requests = named_requests(body) if form >= 4 else []
    digests = [body.bytes(8) for _ in range(steps + 1)]
    clock = [summed(body.column(steps + 1)) for _ in range(CLOCK)]
    ticks = [0, *(max(0, min(62, now // 16 - then // 16)) for then, now in zip(clock[0], clock[0][1:], strict=False))]
    seats = [hunter(body, config, seat, ticks, commands.get(seat)) for seat in range(hunters)]
    prey = [[summed(body.column(steps + 1)) for _ in range(PREY)] for _ in range(many)]
    moving = config.get("target_motion", "still") != "still" or many > 0
    spans = [body.column(header["spans"]) for _ in range(4 if moving else 2 + TARGET)]
    spans[0] = summed(spans[0])
    alive: list[list[list[int]]] = [[] for _ in clock[0]]
    if moving:
        rows = [n for begin, length, *_ in zip(*spans, strict=True) for n in range(begin, begin + length)]
        first = {sum(spans[1][:span]) for span in range(header["spans"])}
        motion = [body.column(len(rows)) for _ in range(MOTION)]
        numbers = [number for _, length, number, _ in zip(*spans, strict=True) for _ in range(length)]
        given = {which: summed(motion[which]) for which in (LINEAR, ANGULAR)}
        for at, n in enumerate(rows):
            for index in range(many):
                if at not in first and prey[index][0][n] == numbers[at]:
                    for which, velocity in zip(
                        (LINEAR, ANGULAR), asked_of_prey(config, prey_commands[index], n), strict=True
                    ):
                        given[which][at] += velocity
        motion = moved(motion, [0 if at in first else ticks[n] for at, n in enumerate(rows)], given)
        at = 0
        for begin, length, number, appeared in zip(*spans, strict=True):
            for n in range(begin, begin + length):
                x, y, theta, v, w, flag = (column[at] for column in motion)
                alive[n].append([number, x, y, theta, appeared, v, w, flag])
                at += 1
    else:
        for begin, length, *target in zip(*spans, strict=True):
            for n in range(begin, begin + length):
                alive[n].append(target)
    assert body.at == len(body.data)
    states = []
    for n in range(steps + 1):
        numbers = [column[n] for column in clock]
        numbers += [column[n] for seat in seats for column in seat]
        numbers += [number for target in sorted(alive[n]) for number in target]
        states.append(numbers + [column[n] for one in prey for column in one])
    return {
        **header,
        "ranks": ranks,
        "commands": commands,
        "prey_commands": prey_commands,
        "named_requests": requests,
        "digests": digests,
        "states": states,
    }


def named_requests(body: Body) -> list[tuple[int, int, str | None]]:
    """(steps before, seat, name) of each."""
    names = json.loads(body.bytes(struct.unpack("<I", body.bytes(4))[0]).decode("utf-8"))
    (count,) = struct.unpack("<I", body.bytes(4))
    later, seats, places = (body.column(count) for _ in range(3))
    return [(step, seat, names[place]) for step, seat, place in zip(summed(later), seats, places, strict=True)]


def asked_of_prey(config: dict[str, Any], commands: list[list[float]], n: int) -> list[int]:
    """The velocities that a prey's command asks for which leads to state n."""
    fastest, quickest = config["target_speed_mps"], config["target_turn_rate_radps"]
    limits = ((-fastest if config["reverse"] else 0.0, fastest), (-quickest, quickest))
    return [
        millionths(max(low, min(high, column[n - 1] * high)))
        for column, (low, high) in zip(commands, limits, strict=True)
    ]


def float32(rotated: int) -> float:
    word = (rotated >> 1) | ((rotated & 1) << 31)
    return struct.unpack("<f", struct.pack("<I", word))[0]


def summed(rest: list[int]) -> list[int]:
    total, found = 0, []
    for number in rest:
        total += number
        found.append(total)
    return found


def millionths(number: float) -> int:
    return max(-(2**53), min(2**53, math.floor(MILLION * number + 0.5)))


def hunter(
    body: Body, config: dict[str, Any], seat: int, ticks: list[int], commands: list[list[float]] | None
) -> list[list[int]]:
    """The eleven columns of one seat."""
    rest = [body.column(len(ticks)) for _ in range(HUNTER)]
    if commands is None:
        found = moved(rest, ticks)
    else:
        fastest, quickest = (
            setting[seat] if isinstance(setting, list) else setting
            for setting in (config["max_speed_mps"], config["max_turn_rate_radps"])
        )
        limits = ((-fastest if config["reverse"] else 0.0, fastest), (-quickest, quickest))
        given = {}
        for which, fractions, (low, high) in zip((LINEAR, ANGULAR), commands, limits, strict=True):
            velocities = [0, *(millionths(max(low, min(high, part * high))) for part in fractions)]
            given[which] = [left + number for left, number in zip(rest[which], velocities, strict=True)]
        found = moved(rest, ticks, given)
    found[ACTIVE] = rest[ACTIVE]
    return found


def moved(rest: list[list[int]], ticks: list[int], given: dict[int, list[int]] | None = None) -> list[list[int]]:
    """The columns of something that moves: x, y, theta, v, w, and what else there is."""
    found = [summed(column) for column in rest]
    for which, column in (given or {}).items():
        found[which] = column
    x, y, theta = [0], [0], [0]
    for n, k in enumerate(ticks):
        v, w = found[LINEAR][n], found[ANGULAR][n]
        angle, turn, stride = theta[-1] / MILLION, w / MILLION * 0.016, v * 0.016
        way_x = way_y = 0.0
        for _ in range(k):
            angle = angle + turn
            sine, cosine = sincos(angle)
            way_x = way_x + cosine * stride
            way_y = way_y + sine * stride
        theta.append(theta[-1] + rest[2][n] + (16 * w * k + 500) // 1000)
        x.append(x[-1] + rest[0][n] + math.floor(way_x + 0.5))
        y.append(y[-1] + rest[1][n] + math.floor(way_y + 0.5))
    found[:3] = x[1:], y[1:], theta[1:]
    return found
