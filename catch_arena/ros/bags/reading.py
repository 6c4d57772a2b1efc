"""A bag of turtlesim and the exercise's nodes, read: anybody's, so nothing in it is taken for granted."""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from rosbags.interfaces import Connection, MessageDefinitionFormat
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

from catch_arena.config import TURTLESIM_SIDE_M
from catch_arena.errors import ReplayError, reason
from catch_arena.messages import Pose, Turtle, TurtleArray
from catch_arena.ros.bags.contents import BagContents, Listed, Place, Placed, RecordedRequest, Track
from catch_arena.ros.bags.service_events import (
    REQUEST_RECEIVED,
    REQUEST_SENT,
    RESPONSE_RECEIVED,
    RESPONSE_SENT,
    TOPIC,
    event_of,
)
from catch_arena.ros.middleware.graph_names import ALIVE_TURTLES, POSE, TURTLE, pose_of
from catch_arena.ros.middleware.interfaces import Interfaces, MessageType
from catch_arena.ros.middleware.typestore import register
from catch_arena.text import one_line

LONGEST_MS: Final = 24 * 3_600_000
"""As a replay's."""
_OUTSIDE_M: Final = 0.01
"""A pose may lie so far beyond a wall; turtlesim clamps."""
_GONE_MS: Final = 250.0
"""A turtle that is silent for so long has gone: turtlesim tells poses every 16 ms."""
_OWN_HUNTER: Final = re.compile(r"hunter_\d+")
_MOST_TURTLES: Final = 10_000
"""In one list."""


@dataclass(slots=True)
class _BagListener:
    """What has been read so far."""

    tracks: dict[str, Track] = field(default_factory=dict)
    lists: list[Listed] = field(default_factory=list)
    left: list[RecordedRequest] = field(default_factory=list)
    """Targets that left the list."""
    called: dict[tuple[str, bytes, int], RecordedRequest] = field(default_factory=dict)
    """Calls of the service."""
    listed: set[str] = field(default_factory=set)
    """All names that ever stood in a list."""
    alive: dict[str, Place] = field(default_factory=dict)
    """Those of the last list."""
    end_ms: float = 0.0
    left_out: int = 0

    def situation(self) -> tuple[dict[str, Place], dict[str, Place]]:
        """Where everybody is, as far as was told: those whose poses are, and the targets of the list."""
        poses = {name: track.placed[-1].pose[:2] for name, track in self.tracks.items()}
        return poses, {name: poses.get(name, place) for name, place in self.alive.items()}

    # each of these takes one message, or raises ValueError for what it cannot be

    def on_pose(self, name: str, time_ms: float, message: Any) -> None:
        """Of a turtle."""
        pose = Pose(*(float(getattr(message, part)) for part in Pose._fields))
        low, high = -_OUTSIDE_M, TURTLESIM_SIDE_M + _OUTSIDE_M
        if not (all(map(math.isfinite, pose)) and low <= pose.x <= high and low <= pose.y <= high):
            raise ValueError("a pose lies outside the window")
        track = self.tracks.setdefault(name, Track())
        if track.placed and track.placed[-1].time_ms >= time_ms:
            track.placed.pop()  # two in one instant: the later one counts
            if track.placed and track.placed[-1].time_ms >= time_ms:
                raise ValueError("time goes backwards")
        track.placed.append(Placed(time_ms, pose))

    def on_list(self, time_ms: float, message: Any) -> None:
        """Of who is alive. Who was in the last one and is no longer has left."""
        if len(message.turtles) > _MOST_TURTLES:
            raise ValueError("a list is too long")
        turtles = tuple(Turtle(str(one.name), float(one.x), float(one.y), float(one.theta)) for one in message.turtles)
        if not all(math.isfinite(number) for turtle in turtles for number in turtle[1:]):
            raise ValueError("a target is nowhere")
        poses, targets = self.situation()
        names = {turtle.name for turtle in turtles}
        self.left += [
            RecordedRequest(time_ms, name, None, success=True, hunters=poses, targets=targets)
            for name in self.alive
            if name not in names
        ]
        self.listed |= names
        self.alive = {turtle.name: (_within(turtle.x), _within(turtle.y)) for turtle in turtles}
        self.lists.append(Listed(time_ms, TurtleArray(turtles)))

    def on_call(self, hunter: str | None, topic: str, time_ms: float, message: Any) -> None:
        """A request, or its response; both ends may tell of each."""
        info = message.info
        key = topic, bytes(info.client_gid), int(info.sequence_number)
        if info.event_type in {REQUEST_SENT, REQUEST_RECEIVED} and message.request:
            if key not in self.called or info.event_type == REQUEST_RECEIVED:
                known = self.called.get(key)
                poses, targets = self.situation()
                self.called[key] = RecordedRequest(
                    time_ms,
                    str(message.request[0].name),
                    hunter,
                    success=None if known is None else known.success,
                    hunters=poses,
                    targets=targets,
                )
        elif info.event_type in {RESPONSE_SENT, RESPONSE_RECEIVED} and message.response and key in self.called:
            self.called[key].success = bool(message.response[0].success)


def read_bag(path: Path, progress: Callable[[int, int], None] | None = None) -> BagContents:
    """What a bag tells.

    Args:
        path: a folder with metadata.yaml, or an .mcap or .db3 file.
        progress: called with (messages read, messages in all).

    Raises:
        ReplayError: for what is no such bag, or has no hunter in it; one line.
    """
    heard = _BagListener()
    unreadable: dict[str, str] = {}
    with _opened(path) as bag:
        handlers = _handlers(path, heard, bag.connections)
        if not handlers:
            raise ReplayError(f"{path}: has no poses of turtlesim: record with ros2 bag record -a")
        first: int | None = None
        wanted = [one for one in bag.connections if one.topic in handlers]
        total = sum(one.msgcount for one in wanted)
        for done, (connection, time_ns, data) in enumerate(bag.messages(wanted), start=1):
            first = time_ns if first is None else first
            time_ms = (time_ns - first) / 1e6
            if not 0.0 <= time_ms <= LONGEST_MS:
                raise ReplayError(f"{path}: must last 24 hours at most, and its time must not go backwards")
            decode, handle = handlers[connection.topic]
            try:
                handle(time_ms, decode(data))
                heard.end_ms = time_ms
            except Exception as error:  # noqa: BLE001 - a stranger's bytes, read by a stranger's definitions
                heard.left_out += 1
                unreadable.setdefault(connection.topic, reason(error))
            if progress is not None:
                progress(done, total)
    return _contents(path, heard, unreadable)


def _contents(path: Path, heard: _BagListener, unreadable: Mapping[str, str]) -> BagContents:
    for topic, why in unreadable.items():
        if topic.endswith(ALIVE_TURTLES) and not heard.lists:
            raise ReplayError(
                f"{path}: {topic}: none of its messages can be read as TurtleArray with string name, float64 x, y, "
                f"theta: {one_line(why)}"
            )
    if not heard.tracks:
        why = f": {one_line(next(iter(unreadable.values())))}" if unreadable else ""
        raise ReplayError(f"{path}: holds no pose that can be read{why}")
    hunters = _hunters(heard)
    if not hunters:
        raise ReplayError(f"{path}: holds poses of targets alone: record {pose_of(TURTLE)} too")
    targets = {name: track for name, track in heard.tracks.items() if name not in hunters and name in heard.listed}
    asked = list(heard.called.values()) if heard.called else heard.left
    if not heard.lists:
        targets = {name: track for name, track in heard.tracks.items() if _named(name) != _named(next(iter(hunters)))}
        asked = asked or _silenced(heard, hunters, targets)
    for one in asked:
        one.hunters = {name: one.hunters.get(name, hunters[name].placed[0].pose[:2]) for name in hunters}
    return BagContents(
        hunters, targets, heard.lists, sorted(asked, key=lambda one: one.time_ms), heard.end_ms, heard.left_out
    )


def _hunters(heard: _BagListener) -> dict[str, Track]:
    """Who never was a target. Where the arena's own hunters are, turtle1 is another name of one of them; where no list
    was recorded nobody knows more than names.
    """
    free = [name for name in heard.tracks if name not in heard.listed]
    own = sorted((name for name in free if _OWN_HUNTER.fullmatch(name)), key=lambda name: int(name[7:]))
    if own:
        free = own
    elif not heard.lists:
        free = [name for name in free if name == TURTLE]
    return {name: heard.tracks[name] for name in free}


def _named(name: str) -> str:
    return "hunter" if name == TURTLE or _OWN_HUNTER.fullmatch(name) else name


def _silenced(heard: _BagListener, hunters: Mapping[str, Track], targets: Mapping[str, Track]) -> list[RecordedRequest]:
    """Where no list was recorded: the targets whose poses end before the bag does."""
    found = []
    for name, track in targets.items():
        if track.end_ms < heard.end_ms - _GONE_MS:
            time_ms = track.end_ms
            alive = {
                other: one.last(time_ms)[:2] for other, one in targets.items() if one.begin_ms <= time_ms <= one.end_ms
            }
            poses = {hunter: one.last(time_ms)[:2] for hunter, one in hunters.items()}
            found.append(RecordedRequest(time_ms, name, None, success=True, hunters=poses, targets=alive))
    return found


def _within(number: float) -> float:
    """Where turtlesim puts what is spawned outside its window."""
    return min(max(number, 0.0), TURTLESIM_SIDE_M)


@contextmanager
def _opened(path: Path) -> Iterator[Reader]:
    """A bag, and whatever is wrong with it in one line."""
    try:
        with Reader(path) as bag:
            yield bag
    except ReplayError:
        raise
    except FileNotFoundError as error:
        missing = "no such file" if not path.exists() else "is no bag: it holds no metadata.yaml"
        raise ReplayError(f"{path}: {missing}") from error
    except (OSError, MemoryError) as error:
        raise ReplayError(f"{path}: cannot be read: {reason(error)}") from error
    except Exception as error:
        raise ReplayError(f"{path}: is no bag, or a damaged one: {one_line(reason(error))}") from error


_Handler = tuple[Callable[[bytes], Any], Callable[[float, Any], None]]
"""How a topic's messages are read, and what is done with them."""


def _handlers(path: Path, heard: _BagListener, connections: "list[Connection]") -> dict[str, _Handler]:
    """By topic: those that tell of the game."""
    found: dict[str, _Handler] = {}
    plain = Interfaces()
    lists = {one.topic for one in connections if one.msgtype.endswith("/msg/TurtleArray")}
    poses = 0
    for one in connections:
        package, _, kind = one.msgtype.rpartition("/")
        if kind == "Pose" and package in {"turtlesim/msg", "turtlesim_msgs/msg"} and one.topic.endswith(POSE):
            name = one.topic.strip("/").removesuffix(POSE)
            found[one.topic] = _decoder(plain.pose), _pose_handler(heard, name)
            poses += 1
        elif one.topic in lists and (one.topic.endswith(ALIVE_TURTLES) or len(lists) == 1):
            found[one.topic] = _lists_decoder(path, one), heard.on_list
        elif kind == "CatchTurtle_Event" and one.topic.endswith(TOPIC):
            hunter = one.topic.strip("/").removesuffix(TOPIC).rpartition("/")[0] or None
            types = Interfaces(package.removesuffix("/srv")) if package.count("/") == 1 else plain
            found[one.topic] = _decoder(event_of(types.catch_turtle)), _call_handler(heard, hunter, one.topic)
    return found if poses else {}


def _pose_handler(heard: _BagListener, name: str) -> Callable[[float, Any], None]:
    return lambda time_ms, message: heard.on_pose(name, time_ms, message)


def _call_handler(heard: _BagListener, hunter: str | None, topic: str) -> Callable[[float, Any], None]:
    return lambda time_ms, message: heard.on_call(hunter, topic, time_ms, message)


def _decoder(kind: MessageType) -> Callable[[bytes], Any]:
    store = get_typestore(Stores.ROS2_JAZZY)
    register(store, kind)
    return lambda data: store.deserialize_cdr(data, kind.name)


def _lists_decoder(path: Path, one: Connection) -> Callable[[bytes], Any]:
    """By the definition that the bag holds, so that other widths are read as they are; Humble's files hold none."""
    if one.msgdef.format == MessageDefinitionFormat.NONE:
        return _decoder(Interfaces(one.msgtype.partition("/")[0]).turtle_array)
    store = get_typestore(Stores.EMPTY)
    try:
        if one.msgdef.format == MessageDefinitionFormat.MSG:
            store.register(get_types_from_msg(one.msgdef.data, one.msgtype))
        else:
            for part in one.msgdef.data.split("=" * 80 + "\n"):
                store.register(get_types_from_idl(part.partition("\n")[2] if part.startswith("IDL: ") else part))
        store.get_msgdef(one.msgtype)
    except Exception as error:  # a stranger's definition
        raise ReplayError(f"{path}: {one.topic}: its definition cannot be read: {one_line(reason(error))}") from error
    return lambda data: store.deserialize_cdr(data, one.msgtype)
