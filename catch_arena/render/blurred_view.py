"""R7.6: places at which a hunter believes other turtles to be, by its own observation."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.explanation.seen_targets import SeenTargets
from catch_arena.layout import columns
from catch_arena.world import World


class Belief(NamedTuple):
    """Believed place [m] of a target or another hunter that a hunter sees."""

    x: float
    y: float
    target: int | None = None
    """Number of the target, None for a hunter."""
    rival: int | None = None
    """Seat of the other hunter, None for a target."""


class BlurredView:
    """Beliefs of the hunters of an arena."""

    def __init__(self, config: ArenaConfig) -> None:
        self._seen = SeenTargets(config)
        self._places = {column.name: place for place, column in enumerate(columns(config))}

    def beliefs(self, world: World, seat: int, observation: NDArray[np.float32]) -> list[Belief]:
        """Return a hunter's beliefs in a world, by its observation of that world, (D,)."""
        numbers = {target.name: target.number for target in world.targets}
        found = [
            Belief(*self._place(world, seat, observation, f"target_{rank}"), target=numbers[name])
            for rank, name in enumerate(self._seen.ranked(world, seat), start=1)
        ]
        return found + [
            Belief(*self._place(world, seat, observation, f"rival_{rank}"), rival=rival_seat)
            for rank, rival_seat in enumerate(self._seen.ranked_rivals(world, seat), start=1)
        ]

    def _place(self, world: World, seat: int, observation: NDArray[np.float32], seen: str) -> tuple[float, float]:
        """Return the believed place of `seen`, turned from the hunter's frame into the world's [m]."""
        me = world.hunters[seat]
        forward, left = (float(observation[self._places[f"{seen}.{name}"]]) for name in ("forward", "left"))
        sine, cosine = np.sin(me.theta), np.cos(me.theta)
        return float(me.x + cosine * forward - sine * left), float(me.y + sine * forward + cosine * left)
