"""Rulings of the arbiter on the catches of a bag."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Final

from catch_arena.arbitration import arbitrate
from catch_arena.explanation.formatting import metres
from catch_arena.ros.bags.contents import BagContents, Place, RecordedRequest
from catch_arena.text import printable
from catch_arena.verdicts import Ruling

_STAYS_MS: Final = 500.0
"""A target with poses for longer after it was caught was not killed."""
_LONGEST_NAME: Final = 60


@dataclass(frozen=True, slots=True)
class JudgedCatch:
    """One request of a bag, and its ruling."""

    request: RecordedRequest
    hunter: str
    """The hunter that asked; the nearest one if the bag does not have it."""
    ruling: Ruling

    @property
    def agrees(self) -> bool:
        """True if the recorded answer is the arbiter's, or missing."""
        return self.request.success in {None, self.ruling.success}

    def __str__(self) -> str:
        """One line: time, hunter, target, distance, and the ruling with its clause."""
        name = printable(self.request.name[:_LONGEST_NAME]) or "a target without a name"
        did = {True: "caught", False: "was refused", None: "asked for"}[self.request.success]
        distance = "" if self.ruling.distance_um is None else f" from {metres(self.ruling.distance_um)}"
        but = "" if self.agrees else "but "
        return (
            f"{self.request.time_ms / 1000.0:9.3f} s  {self.hunter} {did} {name}{distance}: "
            f"{but}{self.ruling.verdict.name}, {self.ruling.reason}"
        )


def judge_bag(bag: BagContents, reach_m: float = 0.3) -> list[JudgedCatch]:
    """Judge the requests of a bag in their order, each by the last poses before it.

    Requests of one instant are judged together (R5.1). A tie is drawn as in a match with the seed 0.

    Raises:
        ConfigError: for a reach that is not allowed.
    """
    names = tuple(bag.hunters)
    caught: set[str] = set()
    judged: list[JudgedCatch] = []
    for time_ms, group in groupby(bag.requests, key=lambda one: one.time_ms):
        requests = list(group)
        hunters = [track.last(time_ms)[:2] for track in bag.hunters.values()]
        targets = _targets(bag, requests[0])
        seats = [
            names.index(one.hunter) if one.hunter in names else _nearest(hunters, targets.get(one.name))
            for one in requests
        ]
        rulings = arbitrate(
            hunters=hunters,
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
    """Return one line: the number of catches, and of those that the arbiter grants."""
    granted = [one.ruling.success for one in judged if one.request.success]
    refused = [one.ruling.success for one in judged if not one.request.success]
    line = f"catches: {len(granted)} in the recording, {sum(granted)} of them granted by the arbiter"
    if refused:
        line += f"; {len(refused)} request{'s' if len(refused) > 1 else ''} refused, {sum(refused)} of which it grants"
    return line


def _targets(bag: BagContents, request: RecordedRequest) -> dict[str, Place]:
    """Return the places of the targets that can be caught: listed, with a name, and in the simulator if its poses were
    recorded. A target's own pose counts if there is one.
    """
    places = {}
    for name, listed in request.listed.items():
        track = bag.targets.get(name)
        if track is not None:
            places[name] = track.last(request.time_ms)[:2] if track.begin_ms <= request.time_ms else listed
        elif name and not bag.targets:
            places[name] = listed
    return places


def _nearest(hunters: Sequence[Place], target: Place | None) -> int:
    return 0 if target is None else min(range(len(hunters)), key=lambda seat: math.dist(hunters[seat], target))


def _stays(bag: BagContents, one: RecordedRequest) -> bool:
    track = bag.targets.get(one.name)
    return track is not None and track.begin_ms <= one.time_ms and track.end_ms > one.time_ms + _STAYS_MS
