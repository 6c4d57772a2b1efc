"""What a match's stream of random numbers is worth: how many tries a seed takes, and how many are left to an agent that
drives into a corner, turns on the spot, and works out the places that it sees (docs/isolation.md, "What an agent can
work out").

A.5's words are those of SplitMix64, which is a permutation: whoever has a whole word has the stream. Views are rounded
to float32, but differently in each step; in a corner the hunter's own place is known exactly.
"""

import argparse
import math
import os
import platform
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from catch_arena import scenario
from catch_arena.core.physics import TICK_MS
from catch_arena.core.spawner import spawn_pose
from catch_arena.envs.parallel import CatchArenaEnv
from catch_arena.policy import Limits, SeenTarget, View

LOW: Final = 0.5
HIGH: Final = 10.5
"""Places of the standard arena lie between these [m] (A.6)."""
GOLDEN: Final = 0x9E3779B97F4A7C15
PLACE: Final = 2
WORD: Final = 2**64
TURN: Final = 0.7371
"""How it turns in the corner, as a part of what it can: no round number, so that roundings differ."""
SLACK: Final = 1e-13

Polygon = list[tuple[float, float]]


@dataclass(frozen=True, slots=True)
class Corner:
    """What was seen from the corner."""

    views: tuple[View, ...]
    places: tuple[tuple[float, float, float], ...]
    """The truth: x, y [m] and theta [rad] of the places, by their numbers, from 1."""


def corner_views(seed: int, count: int) -> Corner:
    """Drive hunter 0 of a standard match into the corner (0, 0) and turn there; the others hold."""
    config = scenario("standard", control="velocity")
    env = CatchArenaEnv(config)
    observations, _ = env.reset(seed=seed)
    limits = Limits.of(env.config, 0)
    views: list[View] = []
    while len(views) < count:
        view = View(observations["hunter_0"].tolist(), (), limits)
        if view.x == view.y == 0.0:
            views.append(view)
            action = (0.0, TURN)
        else:
            error = math.remainder(math.atan2(-view.y - 3.0, -view.x - 3.0) - view.heading, math.tau)
            action = (1.0 if abs(error) < 1.0 else 0.0, max(-1.0, min(1.0, 2.0 * error)))
        still = {agent: np.zeros(2, dtype=np.float32) for agent in env.agents}
        observations, *_ = env.step(still | {"hunter_0": np.array(action, dtype=np.float32)})
    numbers = range(1, 100)
    places = tuple(spawn_pose(np.uint64(seed), number, LOW, HIGH, HIGH) for number in numbers)
    return Corner(tuple(views[2:]), places)  # the first two still turn as the way into the corner asked


def rounding(value: float) -> float:
    """How far a float32 may be from what was rounded to it."""
    return float(np.spacing(np.float32(abs(value)))) / 2.0


def headings(views: Sequence[View], turn: float) -> tuple[list[float], float]:
    """The heading in each view, and how far they may be wrong: by as much in all of them [rad]."""
    times = [round(1000.0 * (60.0 - view.time_left)) for view in views]
    turned = [turn * (time // TICK_MS - times[0] // TICK_MS) for time in times]
    first = views[0].heading
    low, high = -math.inf, math.inf
    for view, by in zip(views, turned, strict=True):
        sine, cosine = math.sin(first + by), math.cos(first + by)
        for seen, guess, slope in ((view.heading_cos, cosine, -sine), (view.heading_sin, sine, cosine)):
            if abs(slope) > 0.05:
                ends = sorted((seen + side * rounding(seen) - guess) / slope for side in (-1, 1))
                low, high = max(low, ends[0] - SLACK), min(high, ends[1] + SLACK)
    middle = first + (low + high) / 2.0
    return [middle + by for by in turned], (high - low) / 2.0


def clipped(polygon: Polygon, a: float, b: float, most: float) -> Polygon:
    """The part of a convex polygon where a x + b y <= most."""
    kept: Polygon = []
    for (x1, y1), (x2, y2) in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        over1, over2 = a * x1 + b * y1 - most, a * x2 + b * y2 - most
        if over1 <= 0.0:
            kept.append((x1, y1))
        if over1 * over2 < 0.0:
            part = over1 / (over1 - over2)
            kept.append((x1 + part * (x2 - x1), y1 + part * (y2 - y1)))
    return kept


def fractions_of(seen: Sequence[tuple[float, SeenTarget]], error: float) -> tuple[tuple[float, float], ...]:
    """Between which numbers both fractions of a place must lie, from a target's views: x, then y.

    Args:
        seen: the heading, and what was seen of the target, time after time.
        error: by how much the headings may be wrong.
    """
    first, one = seen[0]
    x = math.cos(first) * one.forward - math.sin(first) * one.left
    y = math.sin(first) * one.forward + math.cos(first) * one.left
    polygon: Polygon = [(-1e-5, -1e-5), (1e-5, -1e-5), (1e-5, 1e-5), (-1e-5, 1e-5)]
    for heading, target in seen:
        sine, cosine = math.sin(heading), math.cos(heading)
        for a, b, told, aside in (
            (cosine, sine, target.forward, target.left),
            (-sine, cosine, target.left, target.forward),
        ):
            room = rounding(told) + abs(aside) * error + SLACK
            expected = a * x + b * y
            polygon = clipped(polygon, a, b, told + room - expected)
            polygon = clipped(polygon, -a, -b, expected + room - told)
    return tuple(
        ((at + min(ends) - LOW - SLACK) / (HIGH - LOW), (at + max(ends) - LOW + SLACK) / (HIGH - LOW))
        for at, ends in ((x, [point[0] for point in polygon]), (y, [point[1] for point in polygon]))
    )


def newest_target(views: Sequence[View], period_ms: int, initial: int) -> tuple[int, list[tuple[int, SeenTarget]]]:
    """Of those that the timer spawned and that were seen throughout, the one with the first number; and its views.

    A target that appeared at n periods has the number initial + n, as long as no firing was skipped.
    """
    found: dict[int, list[tuple[int, SeenTarget]]] = {}
    for at, view in enumerate(views):
        now = round(1000.0 * (60.0 - view.time_left))
        for target in view.targets:
            born = now - round(1000.0 * target.age)
            if born > 0:
                found.setdefault(initial + born // period_ms, []).append((at, target))
    number = max(found, key=lambda one: (len(found[one]), -one))
    return number, found[number]


@njit
def mix(z: np.uint64) -> np.uint64:
    """A.5."""
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@njit
def drawn(key: np.uint64, counter: np.uint64) -> float:
    """A.5: the fraction of one word of a stream."""
    return np.float64(mix(key + (counter + np.uint64(1)) * np.uint64(GOLDEN)) >> np.uint64(11)) * 2.0**-53


@njit
def streams(first: np.uint64, last: np.uint64, counter: np.uint64, low: float, high: float) -> NDArray[np.uint64]:
    """The keys of streams whose word `counter` is in [first, last], and the next one's fraction in [low, high]."""
    found = np.zeros(64, dtype=np.uint64)
    count = 0
    word = first
    while True:
        # A.5's mix, backwards: each of its three steps can be undone
        z = word ^ (word >> np.uint64(31)) ^ (word >> np.uint64(62))
        z = z * np.uint64(0x319642B2D24D8EC3)
        z = z ^ (z >> np.uint64(27)) ^ (z >> np.uint64(54))
        z = z * np.uint64(0x96DE1B173F119089)
        z = z ^ (z >> np.uint64(30)) ^ (z >> np.uint64(60))
        key = z - (counter + np.uint64(1)) * np.uint64(GOLDEN)
        if low <= drawn(key, counter + np.uint64(1)) <= high and count < 64:
            found[count] = key
            count += 1
        if word == last:
            return found[:count]
        word += np.uint64(1)


@njit
def seeds_with(first: np.uint64, count: int, x: float, y: float, error: float) -> NDArray[np.uint64]:
    """The seeds, of `count` from `first` on, whose place number 1 has these fractions."""
    found = np.zeros(64, dtype=np.uint64)
    hits = 0
    for number in range(count):
        seed = first + np.uint64(number)
        key = mix(mix(seed + np.uint64(GOLDEN)) + np.uint64(PLACE) * np.uint64(GOLDEN))
        if abs(drawn(key, np.uint64(0)) - x) <= error and abs(drawn(key, np.uint64(1)) - y) <= error:
            found[hits % 64] = seed
            hits += 1
    return found[:hits]


@dataclass(frozen=True, slots=True)
class Attack:
    """What an agent in a corner can work out."""

    bits: float
    """How many bits of a place's x it knows."""
    tries: int
    keys: NDArray[np.uint64]
    """The streams of places that fit."""
    number: int
    """Whose place it was."""


def attack(corner: Corner, most_tries: int = 1 << 40) -> Attack:
    """Work out the stream of places from what was seen of one target; no keys where that takes too many tries."""
    config = scenario("standard")
    turn = float(np.float32(TURN)) * config.max_turn_rate_radps * TICK_MS / 1000.0
    directions, error = headings(corner.views, turn)
    number, seen = newest_target(corner.views, config.spawn_period_ms, config.initial_targets)
    (low_x, high_x), (low_y, high_y) = fractions_of([(directions[at], target) for at, target in seen], error)
    first, last = int(low_x * WORD), min(int(high_x * WORD), WORD - 1)
    tries = last - first + 1
    keys = np.zeros(0, dtype=np.uint64)
    if tries <= most_tries:
        keys = streams(np.uint64(first), np.uint64(last), np.uint64(3 * (number - 1)), low_y, high_y)
    return Attack(64.0 - math.log2(tries), tries, keys, number)


def place_of(key: np.uint64, number: int) -> tuple[float, float]:
    """Where the target of that number appears, by the key of the stream of places."""
    x, y = (LOW + drawn(key, np.uint64(3 * (number - 1) + j)) * (HIGH - LOW) for j in (0, 1))
    return x, y


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=10.0, help="in the corner")
    arguments = parser.parse_args()
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    seeds_with(np.uint64(0), 1, 0.5, 0.5, 0.0)
    count = 1 << 30
    begin = time.process_time()
    seeds_with(np.uint64(0), count, 0.5, 0.5, 0.0)
    rate = count / (time.process_time() - begin)
    print(f"seeds tried: {rate / 1e6:.0f} million a second and core; 2^63 take {2**63 / rate / 3.156e7:.0f} core-years")
    corner = corner_views(int.from_bytes(os.urandom(8), "little"), 2 + round(10 * arguments.seconds))
    streams(np.uint64(0), np.uint64(0), np.uint64(0), 0.0, 0.0)
    begin = time.process_time()
    found = attack(corner)
    spent = time.process_time() - begin
    right = [key for key in found.keys if place_of(key, 60) == corner.places[59][:2]]
    print(f"{arguments.seconds:g} s in a corner: {found.bits:.1f} bits of a place, {found.tries:.1e} tries are left")
    print(f"in {spent:.1f} s of one core: {len(found.keys)} streams fit, {len(right)} of them the match's own")


if __name__ == "__main__":
    main()
