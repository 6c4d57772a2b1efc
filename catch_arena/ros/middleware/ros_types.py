"""The exercise's types in a student's own package: fields are matched by name, then by kind."""

import re
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from catch_arena.errors import BusError
from catch_arena.ros.middleware.bus import Endpoint
from catch_arena.ros.middleware.graph_names import ALIVE_TURTLES, CATCH_TURTLE
from catch_arena.ros.middleware.interfaces import (
    INTERFACES,
    OWN_PACKAGE,
    Field,
    Interfaces,
    MessageType,
    ServiceType,
)

_KINDS: Final[Mapping[str, str]] = {
    "string": "text",
    "wstring": "text",
    "float": "real number",
    "double": "real number",
    "float64": "real number",
    "boolean": "bool",
    "bool": "bool",
}
"""The kind of a field, by the word for its type in a definition or in Python."""
_BY_KIND: Final = {"text", "bool", "list of messages"}
"""Kinds whose only field may have any name."""
_NAMES: Final[Mapping[str, tuple[str, ...]]] = {"name": ("name", "turtle_name"), "success": ("success", "sucess")}
"""Other names that solutions of the exercise have for a field, the usual one first."""
_LIKELY: Final = re.compile("catch|kill|turtle", re.IGNORECASE)
"""Pattern of the type names that are preferred if several fit: a course's package often has a set_led too."""
_CORRECT: Final = (
    "correct the file, build the package again with colcon and source it; ros2/catch_arena_interfaces is an example"
)
_BUILD: Final = "build your package with colcon, and source its workspace: source install/setup.bash"
_LOOK_S: Final = 2.0
"""Time of the search for nodes that use a package's types, if several packages have them [s]."""


def ros_class(name: str) -> Any:
    """Return ROS's own class of a message or a service, or raise BusError if its package is not built or sourced."""
    package, folder, word = name.split("/")
    try:
        return getattr(import_module(f"{package}.{folder}"), word)
    except (ImportError, AttributeError):
        raise BusError(f"{name} is not known to this ROS: build {package} with colcon, and source it") from None


def found_types(given: Interfaces, graph: Callable[[], Sequence[Endpoint]]) -> Interfaces:
    """Return the types of the nodes on the bus, or else of the only package that has them.

    `given` are the packages of --interfaces and --turtlesim; a package that is not the usual one is taken.
    """
    if given.package != INTERFACES:
        return package_types(given.package, given)
    found: dict[str, Interfaces] = {}
    end = time.monotonic() + _LOOK_S
    while True:
        used = {one.name: one.type for one in graph()}
        turtles, catch = used.get(ALIVE_TURTLES, ""), used.get(CATCH_TURTLE, "")
        if turtles or catch:
            return package_types((turtles or catch).partition("/")[0], given, turtles=turtles, catch=catch)
        found = found or fitting_packages(given)
        if len(found) == 1:
            return next(iter(found.values()))
        if time.monotonic() >= end:
            raise BusError(
                f"several packages have a catch service: {', '.join(found)}; "
                f"choose one, such as --interfaces {next(iter(found))}"
            )
        time.sleep(0.1)


def package_types(package: str, given: Interfaces, *, turtles: str = "", catch: str = "") -> Interfaces:
    """Return a package's types for CatchTurtle and TurtleArray: those of these names, or the only ones that fit.

    A name is that of a type which a node uses: other_msgs/msg/Turtles.
    """

    def service(name: str) -> ServiceType:
        own, wanted = ros_class(name), given.catch_turtle
        request = _matched(f"{name}_Request", own.Request, wanted.request)
        return ServiceType(name, request, _matched(f"{name}_Response", own.Response, wanted.response))

    def message(name: str) -> MessageType:
        return _matched(name, ros_class(name), given.turtle_array)

    catch_turtle = service(catch) if catch else _only(package, "srv", "CatchTurtle", service)
    turtle_array = message(turtles) if turtles else _only(package, "msg", "TurtleArray", message)
    return given.with_types(turtle_array=turtle_array, catch_turtle=catch_turtle)


def fitting_packages(given: Interfaces) -> dict[str, Interfaces]:
    """Return the packages on AMENT_PREFIX_PATH that have the exercise's types, by name; ours only if no other has."""
    packages = sorted(_packages())
    found = _matches(packages, lambda package: package_types(package, given))
    if INTERFACES in found:
        return {INTERFACES: found[INTERFACES]}
    if len(found) > 1:
        found.pop(OWN_PACKAGE, None)
    if not found and given.package in packages:
        return {given.package: package_types(given.package, given)}
    if not found:
        raise BusError(
            f"no package with the types of {INTERFACES} is sourced: {_BUILD}, or name yours with --interfaces, which "
            "prints what it lacks"
        )
    return found


def turtlesim_package(usual: str) -> str:
    """Return turtlesim_msgs, as from Kilted on, if only that is installed; else the usual one."""
    return next(iter(_matches((usual, f"{usual}_msgs"), lambda package: ros_class(f"{package}/msg/Pose"))), usual)


def describe_type(kind: MessageType | ServiceType) -> str:
    """Return the fields that were matched, in ROS's words: `string name, double x, double y`."""
    if isinstance(kind, ServiceType):
        return f"{describe_type(kind.request)} -> {describe_type(kind.response)}"
    words = ((one.type if isinstance(one.type, str) else one.type.name, one.name) for one in kind.fields if one.name)
    return ", ".join(map(" ".join, words)) or "no field"


def _packages() -> Iterator[str]:
    """Yield the packages with messages and services of their own."""
    try:
        resources = import_module("ament_index_python.resources")
    except ImportError:
        return
    for package, prefix in resources.get_resources("rosidl_interfaces").items():
        share = Path(prefix) / "share" / package
        if any(share.glob("srv/*.srv")) and any(share.glob("msg/*.msg")):
            yield package


def _only(package: str, folder: str, usual: str, match: Callable[[str], Any]) -> Any:
    """Return the match of the usual word, or of the only one that fits."""
    try:
        module = import_module(f"{package}.{folder}")
    except ImportError:
        raise BusError(f"{package} has no {folder} that this Python can import: {_BUILD}") from None
    mark = "Request" if folder == "srv" else "get_fields_and_field_types"
    names = [f"{package}/{folder}/{word}" for word in dir(module) if hasattr(getattr(module, word), mark)]
    if f"{package}/{folder}/{usual}" in names:
        return match(f"{package}/{folder}/{usual}")
    found = _matches(names, match)
    likely = {name: one for name, one in found.items() if _LIKELY.search(name.rpartition("/")[2])} or found
    if len(likely) == 1:
        return next(iter(likely.values()))
    if likely:
        several = " and ".join(likely)
        raise BusError(f"{package}: {usual} could be {several}; name one of them {usual}, and build {package} again")
    raise BusError(f"{package}/{folder} has no type that fits {usual}; {_CORRECT}")


def _matches(names: Iterable[str], match: Callable[[str], Any]) -> dict[str, Any]:
    """Return the matches of the names that have one."""
    found = {}
    for name in names:
        with suppress(BusError):
            found[name] = match(name)
    return found


def _matched(name: str, own: Any, wanted: MessageType) -> MessageType:
    """Return the type with the fields of `own` in the places of those that are wanted.

    theta may be missing, and an answer may have no fields.
    """
    own_fields = dict(_flat(own))
    fields = []
    for field in wanted.fields:
        kind = "list of messages" if field.is_sequence else _KINDS[str(field.type)]
        found = _field(own_fields, field.name, kind)
        if found is None and (field.name == "theta" or (field.name == "success" and not own_fields)):
            fields.append(Field("", field.type, is_sequence=False))
            continue
        if found is None:
            has = ", ".join(f"{word} {own_name}" for own_name, word in own_fields.items() if "." not in own_name)
            choice = f", or only one {kind}" if kind in _BY_KIND else ""
            needed = f"it needs one {kind} named {field.name}{choice}"
            raise BusError(f"{name} has {has or 'no field'}: {needed}; {_CORRECT}")
        if isinstance(field.type, MessageType):
            package, _, word = own_fields[found].removeprefix("sequence<").rstrip(">").partition("/")
            element = f"{package}/msg/{word}"
            fields.append(Field(found, _matched(element, ros_class(element), field.type), is_sequence=True))
        else:
            fields.append(Field(found, own_fields[found], is_sequence=False))
    return MessageType(name, wanted.make, tuple(fields))


def _flat(own: Any) -> Iterator[tuple[str, str]]:
    """Yield the fields with ROS's words for their types, also those of the messages in it: `turtle.name`."""
    for name, word in own.get_fields_and_field_types().items():
        yield name, word
        if re.fullmatch(r"\w+/\w+", word):
            inner = ros_class(word.replace("/", "/msg/")).get_fields_and_field_types()
            yield from ((f"{name}.{deeper}", one) for deeper, one in inner.items())


def _field(fields: Mapping[str, str], wanted: str, kind: str) -> str | None:
    """Return the name of the field in the place of a wanted one; None if there is none, or more than one.

    A message's own fields come before those of the messages in it.
    """
    for depth in (0, 1):
        fitting = [name for name, word in fields.items() if name.count(".") == depth and _kind_of(word) == kind]
        for usual in _NAMES.get(wanted, (wanted,)):
            if found := [name for name in fitting if name.rpartition(".")[2] == usual]:
                return found[0] if len(found) == 1 else None
        if fitting and kind in _BY_KIND:
            return fitting[0] if len(fitting) == 1 else None
    return None


def _kind_of(word: str) -> str | None:
    if word.startswith("sequence<") and "/" in word:
        return "list of messages"
    return _KINDS.get(word.partition("<")[0])
