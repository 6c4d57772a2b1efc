"""The spaces of an arena's agents: what they see, and what they may do."""

from typing import Any

import numpy as np
from gymnasium import spaces

from catch_arena.config import ArenaConfig, Control
from catch_arena.layout import Column, columns, prey_columns, state_columns


def observation_space(config: ArenaConfig, control: Control) -> spaces.Space[Any]:
    """R7.1's vector as a Box, with the mask of R7.2 beside it under target control where the config asks for that."""
    box = _box(columns(config))
    if control == "target" and config.mask_in_observation:
        mask = spaces.Box(0, 1, (config.targets_seen + 1,), dtype=np.int8)
        return spaces.Dict({"observation": box, "action_mask": mask})
    return box


def action_space(config: ArenaConfig, control: Control) -> spaces.Space[Any]:
    """R4.1, R4.4: what a hunter of that control may do."""
    choice: spaces.Space[Any] = spaces.Discrete(config.targets_seen + 1)
    if control == "target":
        return choice
    return velocity_space() if control == "velocity" else FullActions({"cmd_vel": velocity_space(), "catch": choice})


class FullActions(spaces.Dict):
    """R4.4: the actions of full control; `sample` takes the mask as infos hold it, and as Gymnasium's Dict does."""

    def sample(self, mask: Any = None, probability: Any = None) -> dict[str, Any]:
        """Return an action, legal by the mask."""
        if isinstance(mask, np.ndarray):
            mask = {"cmd_vel": None, "catch": mask}
        return super().sample(mask, probability)


def velocity_space() -> spaces.Box:
    """R2.5, R12.2: linear and angular velocity as fractions of the limits."""
    return spaces.Box(-1.0, 1.0, (2,), dtype=np.float32)


def prey_observation_space(config: ArenaConfig) -> spaces.Box:
    """R12.4: what prey sees."""
    return _box(prey_columns(config))


def state_space(config: ArenaConfig) -> spaces.Box:
    """R7.3: the global view."""
    return _box(state_columns(config))


def _box(table: tuple[Column, ...]) -> spaces.Box:
    """Vectors of these columns."""
    return spaces.Box(
        np.array([column.low for column in table], dtype=np.float32),
        np.array([column.high for column in table], dtype=np.float32),
        dtype=np.float32,
    )
