"""Rulings of the arbiter on the catches of a bag."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Final

from catch_arena.arbitration import arbitrate
from catch_arena.explanation.formatting import metres
from catch_arena.ros.bags.contents import BagContents, Place, RecordedCatch
from catch_arena.text import printable
from catch_arena.verdicts import Ruling

_LONGEST_NAME: Final = 60


@dataclass(frozen=True, slots=True)
class JudgedCatch:
    """One catch of a bag, and its ruling."""

    catch: RecordedCatch
    hunter: str
    """The hunter nearest to the target: a list does not say who caught it."""
    ruling: Ruling

    def __str__(self) -> str:
        """One line: time, hunter, target, distance, and the ruling with its clause."""
        name = printable(self.catch.name[:_LONGEST_NAME]) or "a target without a name"
        distance = "" if self.ruling.distance_um is None else f" from {metres(self.ruling.distance_um)}"
        contrast = "" if self.ruling.success else "but "
        return (
            f"{self.catch.time_ms / 1000.0:9.3f} s  {self.hunter} caught {name}{distance}: "
            f"{contrast}{self.ruling.verdict.name}, {self.ruling.reason}"
        )


def judge_bag(bag: BagContents, reach_m: float = 0.3) -> list[JudgedCatch]:
    """Judge the catches of a bag in their order, each by the last poses before it.

    Catches of one instant are judged together (R5.1). A tie is drawn as in a match with the seed 0.

    Raises:
        ConfigError: for a reach that is not allowed.
    """
    names = tuple(bag.hunters)
    judged: list[JudgedCatch] = []
    for time_ms, group in groupby(bag.catches, key=lambda one: one.time_ms):
        catches = list(group)
        hunters = [track.last(time_ms)[:2] for track in bag.hunters.values()]
        targets = {name: place for name, place in catches[0].listed.items() if name}  # no name: not in turtlesim
        seats = [_nearest(hunters, targets.get(one.name)) for one in catches]
        rulings = arbitrate(
            hunters=hunters,
            targets=targets,
            requests=[(seat, one.name) for seat, one in zip(seats, catches, strict=True)],
            reach_m=reach_m,
        )
        judged += [
            JudgedCatch(one, names[seat], ruling) for one, seat, ruling in zip(catches, seats, rulings, strict=True)
        ]
    return judged


def summary(judged: Sequence[JudgedCatch]) -> str:
    """Return one line: the number of catches, and of those that the arbiter grants."""
    granted = sum(one.ruling.success for one in judged)
    return f"catches: {len(judged)} in the recording, {granted} of them granted by the arbiter"


def _nearest(hunters: Sequence[Place], target: Place | None) -> int:
    return 0 if target is None else min(range(len(hunters)), key=lambda seat: math.dist(hunters[seat], target))
