"""Check of the actions that agents give, and their conversion into the engine's arrays."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from catch_arena.config import ArenaConfig, Control
from catch_arena.errors import ActionError, suggest
from catch_arena.plain import as_python, plain_action, real_number, whole_number
from catch_arena.text import shortened


class ActionReader:
    """Reader of the actions of one arena's agents, hunters by seat and then prey by index."""

    def __init__(self, config: ArenaConfig, agents: Sequence[str]) -> None:
        self.choices = np.zeros((1, config.hunters), dtype=np.int64)
        """Ranks, as `Engine.step` takes them: (1, H)."""
        self.commands = np.zeros((1, len(agents), 2), dtype=np.float32)
        """Fractions of the limits of velocity, as `Engine.step` takes them: (1, N, 2)."""
        prey_drives: tuple[Control] = ("velocity",)
        controls = config.controls + prey_drives * config.prey
        self.seats = dict(zip(agents, enumerate(controls), strict=True))
        """Row in the engine's arrays and control of each agent; prey has velocity control."""
        self._ranks = config.targets_seen

    def seat(self, agent: str) -> tuple[int, Control]:
        """Return that agent's row in the engine's arrays, and its control; raise ActionError for an unknown agent."""
        seat = self.seats.get(agent) if isinstance(agent, str) else None
        if seat is None:
            shown = shortened(agent)
            near = suggest(agent if isinstance(agent, str) else shown, list(self.seats))
            raise ActionError(f"unknown agent {shown}: {near}")
        return seat

    def read(self, agents: Sequence[str], actions: Mapping[str, Any]) -> None:
        """Write the actions of these agents into `choices` and `commands`; all others hold.

        ActionError is raised for an action that is missing or not legal, and an unknown agent.
        """
        if type(actions) is not dict and not isinstance(actions, Mapping):  # isinstance is slower
            raise ActionError(f"actions must map each agent to its action, got {shortened(actions)}")
        if len(actions) != len(agents):
            self._require_complete(agents, actions)
        choices, commands, seats, ranks = self.choices[0], self.commands, self.seats, self._ranks
        if len(agents) < len(seats):
            choices.fill(0)
            commands.fill(0.0)
        for agent in agents:
            row, control = seats[agent]
            try:
                action = actions[agent]
            except KeyError:
                self._require_complete(agents, actions)
                raise
            if control == "target" and type(action) is int and 0 <= action <= ranks:
                choices[row] = action  # the usual case without another call
            elif control == "velocity":
                commands[0, row, 0], commands[0, row, 1] = _checked_command(agent, "an action", action, clip=True)
            else:
                choices[row], command = checked_action(control, agent, action, ranks, clip=True)
                commands[0, row, 0], commands[0, row, 1] = command

    def _require_complete(self, agents: Sequence[str], actions: Mapping[str, Any]) -> None:
        """Check that each of the agents has an action, and that others are only of agents that have left."""
        for agent in actions:
            self.seat(agent)
        missing = [agent for agent in agents if agent not in actions]
        if missing:
            raise ActionError(f"actions must have an action for each agent, got none for {', '.join(missing)}")


def checked_action(
    control: Control, agent: str, action: Any, ranks: int, *, clip: bool = False
) -> tuple[int, tuple[float, float]]:
    """Return the rank and the two velocities of an action under a control; 0 or (0, 0) for a part that is not read.

    ActionError is raised for an action that is not legal. With `clip`, as in the environments, finite velocities out
    of bounds are legal, and are replaced by the nearest bound.
    """
    if control == "velocity":
        return 0, _checked_command(agent, "an action", action, clip=clip)
    if control == "target":
        return _checked_rank(agent, "an action", action, ranks), (0.0, 0.0)
    named = type(action) is dict or isinstance(action, Mapping)
    if not named or len(action) != 2 or "cmd_vel" not in action or "catch" not in action:
        raise ActionError(f"{agent}: an action must be a mapping with cmd_vel and catch, got {shortened(action)}")
    rank = _checked_rank(agent, "catch", action["catch"], ranks)
    return rank, _checked_command(agent, "cmd_vel", action["cmd_vel"], clip=clip)


def _checked_rank(agent: str, subject: str, action: Any, ranks: int) -> int:
    usual = type(action) is int or type(action) is np.int64  # faster than whole_number
    number = int(action) if usual else whole_number(plain_action(action))
    if number is None or not 0 <= number <= ranks:
        raise ActionError(f"{agent}: {subject} must be a whole number from 0 to {ranks}, got {shortened(action)}")
    return number


def _checked_command(agent: str, subject: str, action: Any, *, clip: bool) -> tuple[float, float]:
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
    except (TypeError, RuntimeError, ValueError):  # the first two of tensors on a graphics card, or with a gradient
        return np.array(None)


def describe_value(given: object) -> str:
    """Return a short description of an argument, for an error."""
    if isinstance(given, np.ndarray):
        return f"an array of {given.dtype} of the shape {given.shape}"
    return shortened(given)


def clipped(commands: NDArray[Any]) -> NDArray[Any]:
    """Return finite velocities within [-1, 1], in an array of its own; NaN and infinities stay."""
    return np.where(np.isfinite(commands), np.clip(commands, -1.0, 1.0), commands)
