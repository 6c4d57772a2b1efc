"""The parameters that the exercise's nodes have, as our own nodes have them: by their names there."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError, suggest
from catch_arena.text import in_short, one_line

SPAWN_FREQUENCY: Final = "spawn_frequency"
NAME_PREFIX: Final = "turtle_name_prefix"
CLOSEST_FIRST: Final = "catch_closest_turtle_first"
_KINDS: Final = {bool: "true or false", float: "a double, as 2.0", str: "a string"}
_PREFIX: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_LONGEST_NAME: Final = 100
"""So much of a name that nobody has is looked at, and told."""

Value = bool | float | str


@dataclass(slots=True)
class Parameter:
    """One parameter. Its value's type is the type that it keeps, as in ROS; whoever uses it reads `value` anew."""

    name: str
    value: Value
    description: str
    check: Callable[[Any], object] = lambda _: None
    """Raises ConfigError for a value that cannot be."""
    fixed: str = ""
    """Why it cannot be changed while the node runs; empty where it can."""


class Parameters:
    """Those of one node.

    Args:
        parameters: each with the value that it has if nobody gives another.

    Raises:
        ConfigError: for a value that cannot be.
    """

    def __init__(self, *parameters: Parameter) -> None:
        self._parameters = {parameter.name: parameter for parameter in parameters}
        for parameter in parameters:
            parameter.check(parameter.value)

    def __iter__(self) -> Iterator[Parameter]:
        return iter(self._parameters.values())

    def __contains__(self, name: object) -> bool:
        return name in self._parameters

    def __getitem__(self, name: str) -> Parameter:
        return self._parameters[name]

    def begin_with(self, name: str, value: object) -> None:
        """Another value, before the node runs.

        Raises:
            ConfigError: for a name that no parameter has, and a value that it cannot have.
        """
        self._checked(name, value).value = value  # type: ignore[assignment]

    def change(self, changes: Sequence[tuple[str, object]]) -> str:
        """New values while the node runs: all of them, or none.

        Returns:
            why it cannot be, in one line; empty where it is done.
        """
        try:
            for name, value in changes:
                parameter = self._checked(name, value)
                if parameter.fixed:
                    raise ConfigError(f"{name} cannot be changed: {parameter.fixed}")
        except ConfigError as error:
            return one_line(str(error))
        for name, value in changes:
            self._parameters[name].value = value  # type: ignore[assignment]
        return ""

    def _checked(self, name: str, value: object) -> Parameter:
        """The one of that name, which can have that value. In ROS a whole number is no double, and here neither: a
        student's own node stops at it.
        """
        if name not in self._parameters:
            name = name[:_LONGEST_NAME]
            known = suggest(name, self._parameters) if self._parameters else "this node has none"
            raise ConfigError(f"there is no parameter {in_short(name)}: {known}")
        parameter = self._parameters[name]
        kind = type(parameter.value)
        if type(value) is not kind:
            raise ConfigError(f"{name} must be {_KINDS[kind]}, got {in_short(value)}")
        try:
            parameter.check(value)
        except ConfigError as error:
            raise ConfigError(f"{name}: {error}") from None
        return parameter


def spawner_parameters(spawn_frequency: float, name_prefix: str) -> Parameters:
    """Those of turtle_spawner: targets a second, and what their names begin with."""
    return Parameters(
        Parameter(SPAWN_FREQUENCY, spawn_frequency, "targets a second; 0 and less is one every 5 s", _check_frequency),
        Parameter(
            NAME_PREFIX,
            name_prefix,
            "what the targets' names begin with",
            _check_turtle_name,
            fixed="the targets that are there have it in their names",
        ),
    )


def arena_parameters(config: ArenaConfig) -> Parameters:
    """Those of turtle_spawner, whose part the arena plays in a match."""
    fixed = "a match keeps its settings; ros serve takes it with --ros-args -p when it starts"
    return Parameters(
        Parameter(
            SPAWN_FREQUENCY,
            float(config.spawn_frequency_hz),
            "targets a second; 0 and less is one every 5 s",
            _check_frequency,
            fixed,
        ),
        Parameter(
            NAME_PREFIX,
            config.name_prefix,
            "what the targets' names begin with",
            lambda prefix: ArenaConfig(name_prefix=prefix),
            fixed,
        ),
    )


def controller_parameters(closest_first: bool | None) -> Parameters:
    """Those of turtle_controller: none (None) where its agent is neither nearest nor first."""
    if closest_first is None:
        return Parameters()
    return Parameters(
        Parameter(CLOSEST_FIRST, closest_first, "whether it drives to the closest target, or to the oldest one")
    )


def _check_frequency(spawn_frequency: float) -> None:
    ArenaConfig(spawn_frequency_hz=spawn_frequency)


def _check_turtle_name(prefix: str) -> None:
    """Turtlesim makes topics of its turtles' names, and ends at a name that no topic can have."""
    if not _PREFIX.fullmatch(prefix[: _LONGEST_NAME + 1]) or len(prefix) > _LONGEST_NAME:
        raise ConfigError(
            f"turtles' names must be letters, digits and underscores, at most {_LONGEST_NAME}, got {in_short(prefix)}"
        )
