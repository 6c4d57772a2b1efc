"""The parameters of our nodes, which have those of the exercise's under the same names."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.text import in_short

SPAWN_FREQUENCY: Final = "spawn_frequency"
NAME_PREFIX: Final = "turtle_name_prefix"
CLOSEST_FIRST: Final = "catch_closest_turtle_first"
_KINDS: Final = {bool: "true or false", float: "a double, as 2.0", str: "a string"}
_PREFIX: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,99}")

Value = bool | float | str


@dataclass(slots=True)
class Parameter:
    """One parameter of a node. `ros2 param set` may change its value while the node runs, and never its type.

    Raises:
        ConfigError: for a value that it cannot have.
    """

    name: str
    value: Value
    description: str
    check: Callable[[Any], object] = lambda _: None
    """Raises ConfigError for a value that the parameter cannot have."""
    fixed: str = ""
    """Why it cannot be changed while the node runs; empty if it can."""

    def __post_init__(self) -> None:
        self.check(self.value)

    def set(self, value: Any) -> None:
        """Set another value.

        Raises:
            ConfigError: for a value that it cannot have. As in ROS a whole number is no double.
        """
        kind = type(self.value)
        if type(value) is not kind:
            raise ConfigError(f"{self.name} must be {_KINDS[kind]}, got {in_short(value)}")
        try:
            self.check(value)
        except ConfigError as error:
            raise ConfigError(f"{self.name}: {error}") from None
        self.value = value


Parameters = dict[str, Parameter]
"""The parameters of one node, by name."""


def spawner_parameters(
    spawn_frequency: float, name_prefix: str, *, check_prefix: Callable[[str], object] | None = None, fixed: str = ""
) -> Parameters:
    """Return the parameters of turtle_spawner: targets a second, and the first part of their names.

    Args:
        spawn_frequency: the first value.
        name_prefix: the other one.
        check_prefix: raises ConfigError for a prefix that is not allowed; None allows those of turtlesim's turtles.
        fixed: why they cannot be changed while the node runs; without it only the prefix cannot.

    Raises:
        ConfigError: for a value that one cannot have.
    """
    frequency = Parameter(
        SPAWN_FREQUENCY,
        spawn_frequency,
        "targets a second; 0 and less is one every 5 s",
        lambda value: ArenaConfig(spawn_frequency_hz=value),
        fixed,
    )
    prefix = Parameter(
        NAME_PREFIX,
        name_prefix,
        "the first part of the targets' names",
        check_prefix or _check_turtle_name,
        fixed or "the targets that are there have it in their names",
    )
    return {one.name: one for one in (frequency, prefix)}


def arena_parameters(config: ArenaConfig) -> Parameters:
    """Return the parameters of turtle_spawner, whose part the arena plays in a match."""
    return spawner_parameters(
        float(config.spawn_frequency_hz),
        config.name_prefix,
        check_prefix=lambda prefix: ArenaConfig(name_prefix=prefix),
        fixed="a match keeps its settings; ros serve takes it with --ros-args -p when it starts",
    )


def controller_parameters(closest_first: bool | None) -> Parameters:
    """Return the parameters of turtle_controller; none if its agent is neither nearest nor first (None)."""
    if closest_first is None:
        return {}
    described = "whether it drives to the closest target, or to the oldest one"
    return {CLOSEST_FIRST: Parameter(CLOSEST_FIRST, closest_first, described)}


def _check_turtle_name(prefix: str) -> None:
    """Refuse a name that no topic can have: turtlesim makes topics of its turtles' names, and ends at such a one."""
    if not _PREFIX.fullmatch(prefix):
        raise ConfigError(
            f"turtles' names must be letters, digits and underscores, at most 100, got {in_short(prefix)}"
        )
