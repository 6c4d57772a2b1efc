"""Spaces of an arena's agents: their observations, and their actions."""

from typing import Any

import numpy as np
from gymnasium import spaces

from catch_arena.config import ArenaConfig, Control
from catch_arena.layout import Column, columns


def observation_space(config: ArenaConfig, control: Control) -> spaces.Space[Any]:
    """R7.1, R7.2: return the space of observations, with the mask under target control if the config asks for it."""
    box = vector_space(columns(config))
    if control == "target" and config.mask_in_observation:
        mask = spaces.Box(0, 1, (config.targets_seen + 1,), dtype=np.int8)
        return spaces.Dict({"observation": box, "action_mask": mask})
    return box


def action_space(config: ArenaConfig, control: Control) -> spaces.Space[Any]:
    """R4.1, R4.4, R12.2: return the space of an agent's actions under that control; prey has velocity control."""
    choice = spaces.Discrete(config.targets_seen + 1)
    command = spaces.Box(-1.0, 1.0, (2,), dtype=np.float32)  # R2.5: fractions of the limits
    full = FullActions({"cmd_vel": command, "catch": choice})
    by_control: dict[Control, spaces.Space[Any]] = {"target": choice, "velocity": command, "full": full}
    return by_control[control]


class FullActions(spaces.Dict):
    """R4.4: space of actions under full control; `sample` takes the mask of the infos, or that of Gymnasium's Dict."""

    def sample(self, mask: Any = None, probability: Any = None) -> dict[str, Any]:
        """Return a random action that the mask allows."""
        if isinstance(mask, np.ndarray):
            mask = {"cmd_vel": None, "catch": mask}
        return super().sample(mask, probability)


def vector_space(table: tuple[Column, ...]) -> spaces.Box:
    """Return a space of vectors with these columns."""
    return spaces.Box(
        np.array([column.low for column in table], dtype=np.float32),
        np.array([column.high for column in table], dtype=np.float32),
        dtype=np.float32,
    )
