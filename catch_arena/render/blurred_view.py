"""R7.6: places at which a hunter believes other turtles to be, by its own observation."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.layout import observation_size
from catch_arena.policy import Limits, SeenHunter, SeenTarget


class Belief(NamedTuple):
    """Believed place [m] of a target or another hunter that a hunter sees."""

    x: float
    y: float
    is_target: bool


def beliefs_of(config: ArenaConfig, seat: int, observation: NDArray[np.float32]) -> list[Belief]:
    """Return a hunter's beliefs by its observation, of at least D numbers: one for each rank in its view."""
    view = Limits.of(config, seat).view(observation[: observation_size(config)].tolist(), [])
    cosine, sine = view.heading_cos, view.heading_sin
    seen: list[SeenTarget | SeenHunter] = [*view.targets, *view.rivals]
    return [
        Belief(
            view.x + cosine * one.forward - sine * one.left,
            view.y + sine * one.forward + cosine * one.left,
            isinstance(one, SeenTarget),
        )
        for one in seen
    ]
