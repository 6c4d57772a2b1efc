"""The spaces of an arena, and the check of an action against them."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from catch_arena.config import MAX_HEADING_RAD, ArenaConfig, Control
from catch_arena.errors import ActionError
from catch_arena.layout import Column, columns, prey_columns, state_columns
from catch_arena.plain import as_python, plain_action, real_number, whole_number
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
        number = real_number(as_python(value))
        if number is None or not 0.0 <= number <= config.side_m:
            raise ActionError(f"spawn: {axis} must lie in [0, {config.side_m:g}], got {value!r}")
    angle = real_number(as_python(theta))
    if angle is None or not -MAX_HEADING_RAD <= angle <= MAX_HEADING_RAD:
        limits = f"[{-MAX_HEADING_RAD:g}, {MAX_HEADING_RAD:g}]"
        raise ActionError(f"spawn: theta must lie in {limits}, got {theta!r}")


def checked_choice(agent: str, what: str, action: Any, ranks: int) -> int:
    """A rank from 0 to `ranks`.

    Raises:
        ActionError: for an action that is not legal.
    """
    usual = type(action) is int or type(action) is np.int64  # without another call
    number = int(action) if usual else whole_number(plain_action(action))
    if number is None or not 0 <= number <= ranks:
        raise ActionError(f"{agent}: {what} must be a whole number from 0 to {ranks}, got {in_short(action)}")
    return number


def checked_command(agent: str, what: str, action: Any, *, clip: bool = False) -> tuple[float, float]:
    """Two numbers in [-1, 1].

    Args:
        agent: for the error.
        what: the action's name in the error.
        action: two numbers, as a list, a tuple, an array or a tensor.
        clip: whether finite numbers out of bounds become the nearest bound.

    Raises:
        ActionError: for an action that is not legal.
    """
    pair = action.tolist() if isinstance(action, np.ndarray) else action
    if not isinstance(pair, (list, tuple)):
        pair = plain_action(pair)
    if isinstance(pair, (list, tuple)) and len(pair) == 2:
        speed, turn_rate = pair
        if type(speed) is not float or type(turn_rate) is not float:
            speed, turn_rate = real_number(as_python(speed)), real_number(as_python(turn_rate))
        if speed is not None and turn_rate is not None:
            if -1.0 <= speed <= 1.0 and -1.0 <= turn_rate <= 1.0:  # NaN lies nowhere
                return speed, turn_rate
            if clip and -math.inf < speed < math.inf and -math.inf < turn_rate < math.inf:
                return min(max(speed, -1.0), 1.0), min(max(turn_rate, -1.0), 1.0)
    requirement = "two finite numbers" if clip else "two numbers in [-1, 1]"
    raise ActionError(f"{agent}: {what} must be {requirement}, got {in_short(action)}")


def checked_full(agent: str, action: Any, ranks: int, *, clip: bool = False) -> tuple[int, tuple[float, float]]:
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
    return choice, checked_command(agent, "cmd_vel", action["cmd_vel"], clip=clip)


def checked_action(
    control: Control, agent: str, action: Any, ranks: int, *, clip: bool = False
) -> tuple[int, tuple[float, float]]:
    """The rank that a hunter of that control chooses, 0 for none, and the two numbers that it drives by.

    Args:
        control: the hunter's.
        agent: for the error.
        action: what the agent returned.
        ranks: the highest rank.
        clip: whether finite velocities out of bounds become the nearest bound, as in the environments.

    Raises:
        ActionError: for an action that is not legal.
    """
    if control == "full":
        return checked_full(agent, action, ranks, clip=clip)
    if control == "velocity":
        return 0, checked_command(agent, "an action", action, clip=clip)
    return checked_choice(agent, "an action", action, ranks), (0.0, 0.0)


def choice_array(given: Any, axes: int) -> NDArray[Any]:
    """Return the choices of many hunters as one array, each of them read as that of one hunter is.

    Args:
        given: an array, a tensor, or lists of actions.
        axes: how many axes of hunters it has: 2 for (B, H), 1 for (N,).

    Raises:
        ValueError: for rows that differ in length.
    """
    table = _array(given, axes, lambda one: whole_number(plain_action(one)))
    return table.reshape(table.shape[:axes]) if table.ndim > axes and set(table.shape[axes:]) == {1} else table


def command_array(given: Any, axes: int) -> NDArray[Any]:
    """Return the velocities of many hunters as one array; see `choice_array`. Here `axes` counts the last one too."""
    return _array(given, axes, lambda one: real_number(as_python(one)))


def _array(given: Any, axes: int, read: Callable[[Any], object]) -> NDArray[Any]:
    """Return what is given as an array; of objects, where something in a list is not legal."""
    if isinstance(given, list | tuple):
        return np.array(_rows(given, axes, read))
    try:
        table = np.asarray(given)
    except (TypeError, RuntimeError):  # a tensor that needs a gradient, or lies on a graphics card
        table = np.empty((), dtype=object)
    return np.array(_rows(given, axes, read)) if table.dtype == object else table


def _rows(given: Any, axes: int, read: Callable[[Any], object]) -> Any:
    rows = given if isinstance(given, list | tuple) else as_python(given)
    if axes and isinstance(rows, list | tuple):
        return [_rows(row, axes - 1, read) for row in rows]
    return read(given)


def clipped(commands: NDArray[Any]) -> NDArray[Any]:
    """Return finite velocities within [-1, 1], in an array of its own; NaN and infinities stay."""
    return np.where(np.isfinite(commands), np.clip(commands, -1.0, 1.0), commands)
