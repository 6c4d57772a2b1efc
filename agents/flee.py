"""Prey that runs in the direction that takes it farthest from the nearest hunter; hunts as `nearest` does."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.agents.nearest import Agent
from catch_arena.batch_policy import PreyBatchView
from catch_arena.geometry import own_frame
from catch_arena.policy import PreyView
from catch_arena.steering import TURN_GAIN

__all__ = ["Agent", "Prey"]

BEARINGS: Final = 2.0 * np.pi * np.arange(16) / 16 - np.pi
"""Bearings that are compared, evenly spaced over the full circle [rad]."""
AHEAD_S: Final = np.array([0.4, 1.2])
"""Times at which distances are compared [s]: soon, and when a wall may have stopped the prey."""


class Prey:
    """Prey that assumes that hunters drive straight on."""

    def reset(self, seed: int) -> None:
        """Do nothing: the agent keeps no state."""

    def act(self, view: PreyView) -> tuple[float, float]:
        """Return speed and turn rate as fractions of the limits, in [-1, 1]."""
        speed, turn = self.act_batch(PreyBatchView(np.array([view.observation]), view.limits))[0].tolist()
        return speed, turn

    def act_batch(self, view: PreyBatchView) -> NDArray[np.float64]:
        """Return the commands of N prey, (N, 2); `act` gives the same command for one."""
        view = PreyBatchView(view.observations.astype(np.float64), view.limits)
        bearings = BEARINGS[room_m(view).argmax(axis=1)]
        turns = np.clip(TURN_GAIN * bearings / view.limits.max_turn_rate_radps, -1.0, 1.0)
        commands = np.stack((np.ones_like(turns), turns), axis=1)
        commands[view.hunters.present[:, 0] == 0.0] = 0.0
        return commands


def room_m(view: PreyBatchView) -> NDArray[np.float64]:
    """Return the distance to the nearest hunter [m] on each bearing, (N, 16), summed over the times of AHEAD_S."""
    (forward, left), hunters = places(view), view.hunters
    ways = hunters.linear_velocity[:, None] * AHEAD_S[:, None]  # arrays of hunters are (N, 2, K)
    ahead = forward[:, :, None] - (hunters.forward[:, None] + ways * hunters.heading_cos[:, None])[..., None]
    aside = left[:, :, None] - (hunters.left[:, None] + ways * hunters.heading_sin[:, None])[..., None]
    squares = np.where(hunters.present[:, None, :, None] > 0.0, ahead * ahead + aside * aside, np.inf)
    return np.sqrt(squares.min(axis=2)).sum(axis=1)


def places(view: PreyBatchView) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the prey's places after each time on each bearing, forward and left [m]: (N, 2, 16) each.

    Walls and half of the turn count.
    """
    own, limits = view.own, view.limits
    cosines, sines = own.heading_cos[:, None, None], own.heading_sin[:, None, None]
    turning_s = 0.5 * np.abs(BEARINGS) / limits.max_turn_rate_radps
    ways = np.maximum(AHEAD_S[:, None] - turning_s, 0.0) * limits.max_speed_mps
    headings = np.arctan2(sines, cosines) + BEARINGS
    dx, dy = (
        np.clip(start[:, None, None] + ways * part, 0.0, limits.side_m) - start[:, None, None]
        for start, part in ((own.x, np.cos(headings)), (own.y, np.sin(headings)))
    )
    return own_frame(cosines, sines, dx, dy)
