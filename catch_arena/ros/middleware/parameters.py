"""The parameters of our nodes, which have those of the exercise's under the same names."""

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

Value = bool | float | str


@dataclass(slots=True)
class Parameter:
    """One parameter of a node. `ros2 param set` may change its value while the node runs, and never its type."""

    name: str
    value: Value
    description: str
    fixed: str = ""
    """Why it cannot be changed while the node runs; empty if it can."""
    check: Callable[[Any], object] = lambda _: None
    """Raises ConfigError for a value that the parameter cannot have."""

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


def spawner_parameters(spawn_frequency: float, name_prefix: str, fixed: str = "") -> Parameters:
    """Return the parameters of turtle_spawner: targets a second, and the first part of their names.

    Args:
        spawn_frequency: its first value.
        name_prefix: its first value.
        fixed: why neither can be changed while the node runs; without it only the prefix cannot.
    """
    named = fixed or "the targets that are there have it in their names"
    return {
        SPAWN_FREQUENCY: Parameter(
            SPAWN_FREQUENCY,
            spawn_frequency,
            "targets a second; 0 and less is one every 5 s",
            fixed,
            lambda value: ArenaConfig(spawn_frequency_hz=value),
        ),
        NAME_PREFIX: Parameter(NAME_PREFIX, name_prefix, "the first part of the targets' names", named),
    }


def arena_parameters(config: ArenaConfig) -> Parameters:
    """Return the parameters of turtle_spawner, whose part the arena plays in a match."""
    fixed = "a match keeps its settings; ros serve takes it with --ros-args -p when it starts"
    return spawner_parameters(float(config.spawn_frequency_hz), config.name_prefix, fixed)


def controller_parameters(closest_first: bool | None) -> Parameters:
    """Return the parameters of turtle_controller; none if its agent is neither nearest nor first (None)."""
    if closest_first is None:
        return {}
    described = "whether it drives to the closest target, or to the oldest one"
    return {CLOSEST_FIRST: Parameter(CLOSEST_FIRST, closest_first, described)}
