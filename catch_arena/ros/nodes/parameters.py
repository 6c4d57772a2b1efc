"""Parameters that a node is started with: -p NAME:=VALUE after --ros-args."""

from collections.abc import Mapping, Sequence
from typing import Final

from catch_arena.errors import ConfigError, suggest
from catch_arena.text import shortened

Value = bool | float | str
_KINDS: Final = {bool: "true or false", float: "a number", str: "a text"}


def parameters_from(words: Sequence[str] | None, defaults: Mapping[str, Value]) -> dict[str, Value]:
    """Return a node's parameters by name; of several values the last one counts.

    `words` are the arguments after --ros-args. A value must have the type of the parameter's default.
    """
    values, rest = dict(defaults), iter(words or ())
    example = next((f"{name}:={value}".lower() for name, value in defaults.items()), "NAME:=VALUE")
    for word in rest:
        text = next(rest, None)
        if word not in {"-p", "--param"} or text is None:
            raise ConfigError(f"--ros-args must be -p NAME:=VALUE, such as -p {example}, got {word!r}")
        name, sign, value = text.partition(":=")
        if not name or not sign:
            raise ConfigError(f"--ros-args -p must be NAME:=VALUE, such as {example}, got {text!r}")
        if name not in values:
            known = suggest(name, values) if values else "this node has none"
            raise ConfigError(f"there is no parameter {shortened(name)}: {known}")
        kind = type(values[name])
        try:
            values[name] = {"true": True, "false": False}[value.lower()] if kind is bool else kind(value)
        except (KeyError, ValueError):
            raise ConfigError(f"{name} must be {_KINDS[kind]}, got {shortened(value)}") from None
    return values
