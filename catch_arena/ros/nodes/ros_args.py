"""The words after --ros-args, as `ros2 run` and launch files write them: a node's parameters, and its name.

--ros-args -p spawn_frequency:=2.0 --params-file FILE.yaml -r __node:=NAME
"""

import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from catch_arena.errors import BusError, ConfigError, install_hint, suggest
from catch_arena.files import read_text
from catch_arena.ros.middleware.bus import Log
from catch_arena.ros.middleware.parameters import Parameters
from catch_arena.text import in_short, one_line

_NODE: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,254}")
_PARAMETER, _FILE, _REMAP = "-p", "--params-file", "-r"
_WORDS: Final = {"-p": _PARAMETER, "--param": _PARAMETER, "--params-file": _FILE, "-r": _REMAP, "--remap": _REMAP}
_SECTION: Final = "ros__parameters"


def take_ros_args(words: Sequence[str], node: str, parameters: Parameters, log: Log) -> str:
    """Set parameters before the node runs; of several values the last one counts.

    Args:
        words: those after --ros-args.
        node: the node's usual name.
        parameters: its own.
        log: takes one line about a value that is left out.

    Returns:
        the node's name.

    Raises:
        ConfigError: for a word that is not understood, and for a value that cannot be.
        BusError: if the library that reads YAML is not installed.
    """
    pairs = list(_pairs(words))
    for kind, text in pairs:
        if kind == _REMAP:
            node = _node_name(text)
    for kind, text in pairs:
        if kind == _PARAMETER:
            _take_assignment(text, node, parameters)
        elif kind == _FILE:
            _take_file(Path(text), node, parameters, log)
    return node


def _pairs(words: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield each option with its value."""
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


def _take_assignment(text: str, node: str, parameters: Parameters) -> None:
    name, sign, word = text.partition(":=")
    if not name or not sign:
        raise ConfigError(f"--ros-args -p must be NAME:=VALUE, as spawn_frequency:=2.0, got {text!r}")
    of, colon, name = name.rpartition(":")
    if colon and of.removeprefix("/") != node:
        raise ConfigError(f"--ros-args -p {text} is of the node {of}, and this one is {node}")
    value = _load(word, f"--ros-args -p {name}")
    if name not in parameters:
        known = suggest(name, parameters) if parameters else "this node has none"
        raise ConfigError(f"there is no parameter {in_short(name)}: {known}")
    parameters[name].set(value)


def _take_file(file: Path, node: str, parameters: Parameters, log: Log) -> None:
    try:
        text = read_text(file)
    except OSError as error:
        raise ConfigError(f"--params-file {file} cannot be read: {one_line(str(error))}") from None
    nodes = _mapping(_load(text, f"--params-file {file}") or {}, str(file))
    for key in ("/**", "/*", node, f"/{node}"):  # values for all nodes count less
        if key not in nodes:
            continue
        section = _mapping(nodes[key], f"{file}: {key}")
        if _SECTION not in section:
            raise ConfigError(f"{file}: {key} must have {_SECTION}")
        for name, value in _mapping(section[_SECTION], f"{file}: {key}.{_SECTION}").items():
            if name in parameters:
                parameters[name].set(value)
            else:  # a file may be another node's too, or `ros2 param dump` of one that has more
                log(f"warning: {file}: {key} has {in_short(name)}, which is no parameter of {node}: it is left out")


def _mapping(value: object, where: str) -> Mapping[Any, Any]:
    if not isinstance(value, Mapping):
        raise ConfigError(f"{where} must be names with values, got {in_short(value)}")
    return value


def _load(text: str, where: str) -> Any:
    """Return the value of YAML 1.1, as ROS reads it: yes and on are true. None for nothing."""
    try:
        from ruamel.yaml import YAML
        from ruamel.yaml.error import YAMLError
    except ImportError:
        raise BusError(f"--ros-args needs ruamel.yaml, which is not installed: {install_hint('ros')}") from None
    yaml = YAML(typ="safe", pure=True)
    yaml.version = (1, 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of 1e1, which is a double in ROS too
            return yaml.load(text)
    except (YAMLError, TypeError, ValueError, RecursionError) as error:
        raise ConfigError(f"{where} must be YAML: {one_line(str(error))}") from None
