"""Parameters of the exercise's nodes after --ros-args, as `ros2 run` has them: -p spawn_frequency:=2.0."""

from collections.abc import Mapping, Sequence
from typing import Final

from catch_arena.errors import ConfigError, suggest
from catch_arena.text import shortened

SPAWN_FREQUENCY: Final = "spawn_frequency"
NAME_PREFIX: Final = "turtle_name_prefix"
CLOSEST_FIRST: Final = "catch_closest_turtle_first"
_WORDS: Final = {"-p", "--param"}
_BOOLEANS: Final = {"true": True, "false": False}
_KINDS: Final = {bool: "true or false", float: "a number", str: "a text"}

Value = bool | float | str


def parameters_from(words: Sequence[str], defaults: Mapping[str, Value]) -> dict[str, Value]:
    """Return a node's parameters by name; of several values the last one counts.

    Args:
        words: the arguments after --ros-args.
        defaults: values of the parameters that are not given; a given value must have the default's type.

    Raises:
        ConfigError: for an unknown word or parameter, and for a value of another type.
    """
    values = dict(defaults)
    rest = iter(words)
    for word in rest:
        text = next(rest, None)
        if word not in _WORDS or text is None:
            raise ConfigError(f"--ros-args must be -p NAME:=VALUE, such as -p {SPAWN_FREQUENCY}:=2.0, got {word!r}")
        name, sign, value = text.partition(":=")
        if not name or not sign:
            raise ConfigError(f"--ros-args -p must be NAME:=VALUE, such as {SPAWN_FREQUENCY}:=2.0, got {text!r}")
        if name not in values:
            known = suggest(name, values) if values else "this node has none"
            raise ConfigError(f"there is no parameter {shortened(name)}: {known}")
        values[name] = _value(name, value, type(values[name]))
    return values


def _value(name: str, word: str, kind: type) -> Value:
    try:
        return _BOOLEANS[word.lower()] if kind is bool else kind(word)
    except (KeyError, ValueError):
        raise ConfigError(f"{name} must be {_KINDS[kind]}, got {shortened(word)}") from None
