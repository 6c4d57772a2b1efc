"""Rulings of the arbiter on the catches of a bag."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from catch_arena.arbitration import arbitrate
from catch_arena.explanation.formatting import metres
from catch_arena.ros.bags.reading import BagContents
from catch_arena.text import printable
from catch_arena.verdicts import Ruling


@dataclass(frozen=True, slots=True)
class JudgedCatch:
    """One catch of a bag, and its ruling."""

    time_ms: float
    hunter: str
    """The hunter nearest to the target: a list does not say who caught it."""
    ruling: Ruling

    def __str__(self) -> str:
        """One line: time, hunter, target, distance, and the ruling with its clause."""
        name = printable(str(self.ruling.target)[:60]) or "a target without a name"
        distance = "" if self.ruling.distance_um is None else f" from {metres(self.ruling.distance_um)}"
        contrast = "" if self.ruling.success else "but "
        return (
            f"{self.time_ms / 1000.0:9.3f} s  {self.hunter} caught {name}{distance}: "
            f"{contrast}{self.ruling.verdict.name}, {self.ruling.reason}"
        )


def judge_bag(bag: BagContents, reach_m: float = 0.3) -> list[JudgedCatch]:
    """Judge the catches of a bag in their order, each by the last poses before it.

    Targets that leave the list in one message are judged together (R5.1). A tie is drawn as in a match with the seed 0.
    """
    names = tuple(bag.hunters)
    judged: list[JudgedCatch] = []
    for (_, before), (time_ms, after) in pairwise(bag.lists):
        remaining = {turtle.name for turtle in after}
        caught = dict.fromkeys(turtle.name for turtle in before if turtle.name not in remaining)
        if not caught:
            continue
        hunters = [track.last(time_ms)[:2] for track in bag.hunters.values()]
        targets = {turtle.name: (turtle.x, turtle.y) for turtle in before if turtle.name}  # no name: not in turtlesim
        rulings = arbitrate(
            hunters=hunters,
            targets=targets,
            requests=[(_nearest(hunters, targets.get(name)), name) for name in caught],
            reach_m=reach_m,
        )
        judged += [JudgedCatch(time_ms, names[ruling.hunter], ruling) for ruling in rulings]
    return judged


def summary(judged: Sequence[JudgedCatch]) -> str:
    """Return one line: the number of catches, and of those that the arbiter grants."""
    granted = sum(one.ruling.success for one in judged)
    return f"catches: {len(judged)} in the recording, {granted} of them granted by the arbiter"


def _nearest(hunters: Sequence[tuple[float, float]], target: tuple[float, float] | None) -> int:
    return 0 if target is None else min(range(len(hunters)), key=lambda seat: math.dist(hunters[seat], target))
