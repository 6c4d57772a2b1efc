"""Check of the actions that agents give, one by one or in arrays."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from catch_arena.config import Control
from catch_arena.errors import ActionError
from catch_arena.plain import as_python, plain_action, real_number, whole_number
from catch_arena.text import shortened


def checked_action(
    control: Control, agent: str, action: Any, ranks: int, *, clip: bool = False
) -> tuple[int, tuple[float, float]]:
    """Return the rank and the two velocities of an action under a control; 0 or (0, 0) for a part that is not read.

    ActionError is raised for an action that is not legal. With `clip`, as in the environments, finite velocities out
    of bounds are legal, and are replaced by the nearest bound.
    """
    if control == "velocity":
        return 0, checked_command(agent, "an action", action, clip=clip)
    if control == "target":
        return _checked_rank(agent, "an action", action, ranks), (0.0, 0.0)
    named = type(action) is dict or isinstance(action, Mapping)
    if not named or len(action) != 2 or "cmd_vel" not in action or "catch" not in action:
        raise ActionError(f"{agent}: an action must be a mapping with cmd_vel and catch, got {shortened(action)}")
    rank = _checked_rank(agent, "catch", action["catch"], ranks)
    return rank, checked_command(agent, "cmd_vel", action["cmd_vel"], clip=clip)


def _checked_rank(agent: str, subject: str, action: Any, ranks: int) -> int:
    usual = type(action) is int or type(action) is np.int64  # faster than whole_number
    number = int(action) if usual else whole_number(plain_action(action))
    if number is None or not 0 <= number <= ranks:
        raise ActionError(f"{agent}: {subject} must be a whole number from 0 to {ranks}, got {shortened(action)}")
    return number


def checked_command(agent: str, subject: str, action: Any, *, clip: bool) -> tuple[float, float]:
    """Return the two velocities of an action, or of the part of it that `subject` names, as `checked_action` does."""
    pair = action.tolist() if isinstance(action, np.ndarray) else action
    if not isinstance(pair, (list, tuple)):
        pair = plain_action(pair)
    if isinstance(pair, (list, tuple)) and len(pair) == 2:
        speed, turn_rate = pair
        if type(speed) is not float or type(turn_rate) is not float:
            speed, turn_rate = real_number(speed), real_number(turn_rate)
        if speed is not None and turn_rate is not None:
            if -1.0 <= speed <= 1.0 and -1.0 <= turn_rate <= 1.0:  # false for NaN too
                return speed, turn_rate
            if clip and -math.inf < speed < math.inf and -math.inf < turn_rate < math.inf:
                return min(max(speed, -1.0), 1.0), min(max(turn_rate, -1.0), 1.0)
    requirement = "two finite numbers" if clip else "two numbers in [-1, 1]"
    raise ActionError(f"{agent}: {subject} must be {requirement}, got {shortened(action)}")


def action_array(subject: str, given: Any, shape: tuple[int, ...], *, whole: bool = False) -> NDArray[Any]:
    """Return the actions of many agents as one array; each is read as that of a single agent. Its numbers can lie out
    of bounds. ActionError is raised for another type or shape.

    The actions are an array, a tensor or lists: of choices if `whole`, else of velocities.
    """
    table = np.array(None) if isinstance(given, list | tuple) else array_of(given)
    if table.dtype == object:
        table = array_of(_rows(given, len(shape), whole=whole))
    if whole and set(table.shape[len(shape) :]) == {1}:  # each choice may be an array with one element
        table = table.reshape(table.shape[: len(shape)])
    if table.dtype.kind not in ("iu" if whole else "fiu") or table.shape != shape:
        numbers = "whole numbers" if whole else "numbers"
        raise ActionError(f"{subject} must be {numbers} of the shape {shape}, got {describe_value(given)}")
    return table


def _rows(given: Any, axes: int, *, whole: bool) -> Any:
    """Return lists or a tensor as lists of numbers, in which None stands for anything else."""
    rows = given if isinstance(given, list | tuple) else as_python(given)
    if axes and isinstance(rows, list | tuple):
        return [_rows(row, axes - 1, whole=whole) for row in rows]
    return whole_number(plain_action(given)) if whole else real_number(given)


def array_of(given: Any, dtype: DTypeLike | None = None) -> NDArray[Any]:
    """Return an argument as an array; the array of None if NumPy cannot read it, such as rows of different length."""
    try:
        return np.asarray(given, dtype)
    except Exception:  # noqa: BLE001 - foreign objects may raise anything, as tensors on a graphics card do
        return np.array(None)


def describe_value(given: object) -> str:
    """Return a short description of an argument, for an error."""
    if isinstance(given, np.ndarray):
        return f"an array of {given.dtype} of the shape {given.shape}"
    return shortened(given)


def clipped(commands: NDArray[Any]) -> NDArray[Any]:
    """Return finite velocities within [-1, 1], in an array of its own; NaN and infinities stay."""
    return np.where(np.isfinite(commands), np.clip(commands, -1.0, 1.0), commands)
