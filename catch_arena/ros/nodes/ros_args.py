"""What stands behind --ros-args, as `ros2 run` and launch files write it: a node's parameters, and its name.

--ros-args -p spawn_frequency:=2.0 --params-file FILE.yaml -r __node:=NAME
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from catch_arena.errors import BusError, ConfigError, install_hint
from catch_arena.files import read_text
from catch_arena.ros.middleware.bus import Log
from catch_arena.ros.middleware.parameters import Parameters
from catch_arena.text import in_short, one_line

_NODE: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,254}")
_PARAMETER, _FILE, _REMAP = "-p", "--params-file", "-r"
_WORDS: Final = {"-p": _PARAMETER, "--param": _PARAMETER, "--params-file": _FILE, "-r": _REMAP, "--remap": _REMAP}
_SECTION: Final = "ros__parameters"
_ANY_NODE: Final = ("/**", "/*")
"""How files call all nodes."""
_TRUE, _FALSE = (
    {form for word in words for form in (word, word.capitalize(), word.upper())}
    for words in (("y", "yes", "true", "on"), ("n", "no", "false", "off"))
)
_WHOLE: Final = re.compile("[+-]?((?P<hexadecimal>0[xX][0-9a-fA-F]+)|(?P<octal>0[0-7]+)|0|[1-9][0-9]*)")
_INFINITE_OR_NAN: Final = re.compile(r"[+-]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")


def take_ros_args(words: Sequence[str], node: str, parameters: Parameters, log: Log) -> str:
    """Give parameters the values that they are to begin with; of several the last one counts.

    Args:
        words: those behind --ros-args.
        node: what the node is called if nothing else is said.
        parameters: its own.
        log: takes one line about what is left out.

    Returns:
        what the node is called.

    Raises:
        ConfigError: for what cannot be, or is not understood here.
        BusError: where what reads YAML is not installed.
    """
    pairs = list(_pairs(words))
    for kind, text in pairs:
        if kind == _REMAP:
            node = _node_name(text)
    for kind, text in pairs:
        if kind == _PARAMETER:
            parameters.begin_with(*_assignment(text, node))
        elif kind == _FILE:
            _take_file(Path(text), node, parameters, log)
    return node


def _pairs(words: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Each word with the one that belongs to it."""
    rest = iter(words)
    for word in rest:
        if word not in _WORDS:
            raise ConfigError(f"--ros-args must be of -p, --params-file and -r __node:=NAME here, got {word!r}")
        text = next(rest, None)
        if text is None:
            raise ConfigError(f"--ros-args {word} must be followed by what it is about")
        yield _WORDS[word], text


def _node_name(rule: str) -> str:
    source, _, name = rule.partition(":=")
    if source != "__node":
        raise ConfigError(
            f"--ros-args -r must be __node:=NAME, got {rule!r}: topics and services keep their names, and --turtle "
            "names another turtle"
        )
    if not _NODE.fullmatch(name):
        raise ConfigError(f"--ros-args -r __node:= must be letters, digits and underscores, at most 255, got {name!r}")
    return name


def _assignment(text: str, node: str) -> tuple[str, Any]:
    name, sign, value = text.partition(":=")
    if not name or not sign:
        raise ConfigError(f"--ros-args -p must be NAME:=VALUE, as spawn_frequency:=2.0, got {text!r}")
    of, colon, name = name.rpartition(":")
    if colon and of.removeprefix("/") != node:
        raise ConfigError(f"--ros-args -p {text} is of the node {of}, and this one is {node}")
    return name, _load(value, f"--ros-args -p {name}")


def _take_file(file: Path, node: str, parameters: Parameters, log: Log) -> None:
    try:
        text = read_text(file)
    except OSError as error:
        raise ConfigError(f"--params-file {file} cannot be read: {one_line(str(error))}") from None
    nodes = _mapping(_load(text, f"--params-file {file}") or {}, str(file))
    for key in (*_ANY_NODE, node, f"/{node}"):  # what is said of all nodes counts less
        if key not in nodes:
            continue
        section = _mapping(nodes[key], f"{file}: {key}")
        if _SECTION not in section:
            raise ConfigError(f"{file}: {key} must have {_SECTION}")
        for name, value in _mapping(section[_SECTION], f"{file}: {key}.{_SECTION}").items():
            if name in parameters:
                parameters.begin_with(name, value)
            else:  # a file may be another node's too, or `ros2 param dump` of one that has more
                log(f"warning: {file}: {key} has {in_short(name)}, which is no parameter of {node}: it is left out")


def _mapping(value: object, where: str) -> Mapping[Any, Any]:
    if not isinstance(value, Mapping):
        raise ConfigError(f"{where} must be names with values, got {in_short(value)}")
    return value


def _load(text: str, where: str) -> Any:
    """YAML as ROS reads it; None where there is nothing."""
    try:
        from ruamel.yaml import YAML
        from ruamel.yaml.error import YAMLError
    except ImportError:
        raise BusError(f"--ros-args needs ruamel.yaml, which is not installed: {install_hint('ros')}") from None
    yaml = YAML(typ="safe", pure=True)
    try:
        yaml.load(text)  # refuses what two readers may understand differently, as a key that comes twice
        return _value(yaml.compose(text))
    except (YAMLError, ValueError, RecursionError) as error:
        raise ConfigError(f"{where} must be YAML: {one_line(str(error))}") from None


def _value(node: Any) -> Any:
    """What a node of YAML stands for: rcl reads names as they are, and single words by rules of its own."""
    if node is None:
        return None
    if node.id == "mapping":
        return {key.value: _value(value) for key, value in node.value}
    if node.id == "sequence":
        return [_value(item) for item in node.value]
    return node.value if node.style in ("'", '"') else _word(node.value)


def _word(word: str) -> bool | int | float | str | None:
    """A word without quotes: true or false, a whole number, a double, or else a text (rcl_yaml_param_parser)."""
    if word in _TRUE or word in _FALSE:
        return word in _TRUE
    if whole := _WHOLE.fullmatch(word):
        return int(word, 16 if whole["hexadecimal"] else 8 if whole["octal"] else 10)
    if _INFINITE_OR_NAN.fullmatch(word):
        return float(word.replace(".", ""))
    try:
        return word if "_" in word else float(word)
    except ValueError:
        return word or None
