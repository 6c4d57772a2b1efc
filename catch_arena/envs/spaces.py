"""The spaces of an arena, and the check of an action against them."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces

from catch_arena.config import MAX_HEADING_RAD, ArenaConfig, Control
from catch_arena.errors import ActionError
from catch_arena.layout import Column, columns, prey_columns, state_columns
from catch_arena.text import in_short


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


def require_pose(config: ArenaConfig, x: float, y: float, theta: float) -> None:
    """A position in the arena [m] and an angle of at most 1000 [rad], for a target that is spawned by hand.

    Raises:
        ActionError: for anything else.
    """
    for axis, value in (("x", x), ("y", y)):
        if not 0.0 <= value <= config.side_m:
            raise ActionError(f"spawn: {axis} must lie in [0, {config.side_m:g}], got {value!r}")
    if not -MAX_HEADING_RAD <= theta <= MAX_HEADING_RAD:
        limits = f"[{-MAX_HEADING_RAD:g}, {MAX_HEADING_RAD:g}]"
        raise ActionError(f"spawn: theta must lie in {limits}, got {theta!r}")


def checked_choice(agent: str, what: str, action: object, ranks: int) -> int:
    """A rank from 0 to `ranks`.

    Raises:
        ActionError: for an action that is not legal.
    """
    number = action if type(action) is int else _whole_number(action)
    if number is None or not 0 <= number <= ranks:
        raise ActionError(f"{agent}: {what} must be a whole number from 0 to {ranks}, got {in_short(action)}")
    return number


def _whole_number(action: object) -> int | None:
    if isinstance(action, np.integer):
        return int(action)
    if isinstance(action, np.ndarray) and action.size == 1 and action.dtype.kind in "iu":
        return int(action.item())  # with axes too: policies give a row of a batch as an array of the shape (1,)
    return int(action) if isinstance(action, int) and not isinstance(action, bool) else None


def _is_number(given: object) -> bool:
    return isinstance(given, int | float | np.integer | np.floating) and not isinstance(given, bool)


def checked_command(agent: str, what: str, action: Any) -> tuple[float, float]:
    """Two numbers in [-1, 1].

    Raises:
        ActionError: for an action that is not legal.
    """
    pair = action.tolist() if isinstance(action, np.ndarray) else action
    if isinstance(pair, (list, tuple)) and len(pair) == 2:
        speed, turn_rate = pair
        try:  # NaN lies nowhere
            legal = -1.0 <= speed <= 1.0 and -1.0 <= turn_rate <= 1.0
        except (TypeError, ValueError):
            legal = False
        if (
            legal
            and (type(speed) is float or _is_number(speed))
            and (type(turn_rate) is float or _is_number(turn_rate))
        ):
            return speed, turn_rate
    raise ActionError(f"{agent}: {what} must be two numbers in [-1, 1], got {in_short(action)}")


def checked_full(agent: str, action: Any, ranks: int) -> tuple[int, tuple[float, float]]:
    """{"cmd_vel": two numbers in [-1, 1], "catch": a rank}: the rank, and the two.

    Raises:
        ActionError: for an action that is not legal.
    """
    named = type(action) is dict or isinstance(action, Mapping)
    if not named or len(action) != 2 or "cmd_vel" not in action or "catch" not in action:
        raise ActionError(f"{agent}: an action must be a mapping with cmd_vel and catch, got {in_short(action)}")
    choice = action["catch"]
    if type(choice) is not int or not 0 <= choice <= ranks:  # the usual case without another call
        choice = checked_choice(agent, "catch", choice, ranks)
    return choice, checked_command(agent, "cmd_vel", action["cmd_vel"])


def checked_action(control: Control, agent: str, action: Any, ranks: int) -> tuple[int, tuple[float, float]]:
    """The rank that a hunter of that control chooses, 0 for none, and the two numbers that it drives by.

    Raises:
        ActionError: for an action that is not legal.
    """
    if control == "full":
        return checked_full(agent, action, ranks)
    if control == "velocity":
        return 0, checked_command(agent, "an action", action)
    return checked_choice(agent, "an action", action, ranks), (0.0, 0.0)
