"""R7.6: where a hunter believes what it sees to be, by its own observation."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.explanation.seen_targets import SeenTargets
from catch_arena.layout import columns
from catch_arena.world import World


class Belief(NamedTuple):
    """One thing that a hunter sees, and where it believes it to be."""

    x: float
    y: float
    target: int | None = None
    """Its number, where it is a target."""
    rival: int | None = None
    """Its seat, where it is a hunter."""


class BlurredView:
    """What the hunters of an arena believe."""

    def __init__(self, config: ArenaConfig) -> None:
        self._seen = SeenTargets(config)
        self._places = {column.name: place for place, column in enumerate(columns(config))}

    def beliefs(self, world: World, seat: int, observation: NDArray[np.float32]) -> list[Belief]:
        """What a hunter believes in a world of which it got this observation, (D,)."""
        numbers = {target.name: target.number for target in world.targets}
        found = [
            Belief(*self._place(world, seat, observation, f"target_{rank}"), target=numbers[name])
            for rank, name in enumerate(self._seen.ranked(world, seat), start=1)
        ]
        return found + [
            Belief(*self._place(world, seat, observation, f"rival_{rank}"), rival=other)
            for rank, other in enumerate(self._seen.ranked_rivals(world, seat), start=1)
        ]

    def _place(self, world: World, seat: int, observation: NDArray[np.float32], seen: str) -> tuple[float, float]:
        """From the hunter's frame into the world's."""
        me = world.hunters[seat]
        forward, left = (float(observation[self._places[f"{seen}.{name}"]]) for name in ("forward", "left"))
        sine, cosine = np.sin(me.theta), np.cos(me.theta)
        return float(me.x + cosine * forward - sine * left), float(me.y + sine * forward + cosine * left)
