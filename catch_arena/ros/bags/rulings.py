"""What the arbiter would have ruled on the catches of a bag."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Final

from catch_arena.arbitration import arbitrate
from catch_arena.explanation.formatting import metres
from catch_arena.ros.bags.contents import BagContents, RecordedRequest
from catch_arena.text import printable
from catch_arena.verdicts import Ruling, Verdict

_STAYS_MS: Final = 500.0
"""A target that still tells poses so long after it was caught was not killed."""
_LONGEST_NAME: Final = 60


@dataclass(frozen=True, slots=True)
class JudgedCatch:
    """One request of a bag, and its ruling."""

    asked: RecordedRequest
    hunter: str
    """Who asked, or the nearest, where the bag does not tell."""
    ruling: Ruling

    @property
    def agrees(self) -> bool:
        """Whether it was answered as the arbiter would have."""
        return self.asked.success is None or self.asked.success == self.ruling.success

    def __str__(self) -> str:
        """One line: when, who, what, how far, and the ruling with its clause."""
        name = printable(self.asked.name[:_LONGEST_NAME]) or "a target without a name"
        did = {True: "caught", False: "was refused", None: "asked for"}[self.asked.success]
        from_ = "" if self.ruling.distance_um is None else f" from {metres(self.ruling.distance_um)}"
        won = "" if self.agrees else "but "
        return (
            f"{self.asked.time_ms / 1000.0:9.3f} s  {self.hunter} {did} {name}{from_}: "
            f"{won}{self.ruling.verdict.name}, {self.ruling.reason}"
        )


def judge_bag(bag: BagContents, reach_m: float = 0.3) -> list[JudgedCatch]:
    """The requests of a bag in their order, judged where everybody stood by the last poses before each.

    Those of one instant are judged together (R5.1). A tie is drawn as in a match with the seed 0.

    Raises:
        ConfigError: for a reach that cannot be.
    """
    names = tuple(bag.hunters)
    caught: set[str] = set()
    judged: list[JudgedCatch] = []
    for _, together in groupby(bag.asked, key=lambda one: one.time_ms):
        requests = list(together)
        targets = {name: place for name, place in requests[0].targets.items() if not _is_ghost(bag, name)}
        seats = [_seat(names, one) for one in requests]
        rulings = arbitrate(
            hunters=[requests[0].hunters[name] for name in names],
            targets=targets,
            requests=[(seat, one.name) for seat, one in zip(seats, requests, strict=True)],
            reach_m=reach_m,
            caught=caught - targets.keys(),
            kill_refused=[one.name for one in requests if one.success and _stays(bag, one)],
        )
        for one, seat, ruling in zip(requests, seats, rulings, strict=True):
            judged.append(JudgedCatch(one, names[seat], ruling))
            if one.success or ruling.success:
                caught.add(one.name)
    return judged


def summary(judged: Sequence[JudgedCatch]) -> str:
    """One line: how many catches there are, and how many of them the arbiter grants."""
    caught = [one for one in judged if one.asked.success]
    granted = sum(one.ruling.success for one in caught)
    line = f"catches: {len(caught)} in the recording, {granted} of them granted by the arbiter"
    others = [one for one in judged if not one.asked.success]
    if others:
        wrongly = sum(one.ruling.verdict is Verdict.GRANTED for one in others)
        line += f"; {len(others)} request{'s' if len(others) > 1 else ''} refused, {wrongly} of which it grants"
    return line


def _seat(names: Sequence[str], one: RecordedRequest) -> int:
    """Who asked; the nearest where nobody says."""
    if one.hunter in names:
        return names.index(one.hunter)
    place = one.targets.get(one.name)
    if place is None:
        return 0
    return min(range(len(names)), key=lambda seat: math.dist(one.hunters[names[seat]], place))


def _is_ghost(bag: BagContents, name: str) -> bool:
    """What was listed but never was in the simulator: a spawn that failed has an empty name, and no ghost has poses."""
    return not name or (bool(bag.targets) and name not in bag.targets)


def _stays(bag: BagContents, one: RecordedRequest) -> bool:
    track = bag.targets.get(one.name)
    return track is not None and track.begin_ms <= one.time_ms and track.end_ms > one.time_ms + _STAYS_MS
