"""Reading of bags that anyone records of turtlesim and the exercise's nodes: poses of turtles, and targets alive.

Times are milliseconds since the bag's first message.
"""

import math
import os
import re
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Final

from rosbags.interfaces import Connection, MessageDefinitionFormat
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from catch_arena.config import TURTLESIM_SIDE_M
from catch_arena.errors import ReplayError, reason
from catch_arena.messages import Pose, Turtle
from catch_arena.replay.motion import interpolate
from catch_arena.ros.middleware.graph_names import ALIVE_TURTLES, POSE, TURTLE, pose_of
from catch_arena.ros.middleware.interfaces import Interfaces
from catch_arena.ros.middleware.typestore import register
from catch_arena.text import one_line

_LONGEST_MS: Final = 24 * 3_600_000
"""Longest duration of a bag, equal to that of a replay [ms]; a recording machine's clock may jump by years."""
_OUTSIDE_M: Final = 0.01
"""Distance by which a pose may lie outside of turtlesim's window, which clamps in float32 [m]."""
_OWN_HUNTER: Final = re.compile(r"hunter_\d+")

_Handler = Callable[[float, Any], None]
"""Function that takes the time [ms] and one message, and raises an error for a message with impossible values."""


@dataclass(slots=True)
class Track:
    """Poses of one turtle, at least one, in the order of time."""

    times_ms: list[float] = field(default_factory=list)
    poses: list[Pose] = field(default_factory=list)

    def last(self, time_ms: float) -> Pose:
        """Return the last pose at or before a time, or else the first one."""
        return self.poses[max(0, bisect_right(self.times_ms, time_ms) - 1)]

    def at(self, time_ms: float) -> Pose:
        """Return the pose at a time: interpolated between recorded poses, or the nearest end outside the track."""
        after = bisect_right(self.times_ms, time_ms)
        if after in {0, len(self.poses)}:
            return self.last(time_ms)
        begin_ms, end_ms = self.times_ms[after - 1 : after + 1]
        start, stop = self.poses[after - 1 : after + 1]
        part = (time_ms - begin_ms) / (end_ms - begin_ms)
        x, y, theta = interpolate(start[:3], stop[:3], part)
        return Pose(x, y, math.remainder(theta, math.tau), *stop[3:])


@dataclass(frozen=True, slots=True)
class BagContents:
    """Contents of a bag."""

    hunters: Mapping[str, Track]
    """Tracks of the hunters by name, in the order of seats."""
    lists: Sequence[tuple[float, Sequence[Turtle]]]
    """Times [ms] and the targets that were alive from then on, in places clamped to the window as turtlesim does.

    A target that leaves the list was caught.
    """
    end_ms: float
    left_out: int
    """Number of messages that are damaged or have impossible values."""


def read_bag(path: Path, progress: Callable[[int, int], None] | None = None) -> BagContents:
    """Read a bag of turtlesim, a folder with metadata.yaml, or an .mcap or .db3 file.

    `progress` is called with (messages read, messages in all). ReplayError is raised for all other files.
    """
    tracks: dict[str, Track] = {}
    lists: list[tuple[float, Sequence[Turtle]]] = []
    faults: dict[str, str] = {}
    left_out, end_ms = 0, 0.0
    with _opened(path) as bag:
        store = get_typestore(Stores.ROS2_JAZZY)
        handlers = _handlers(path, tracks, lists, bag.connections, store)
        wanted = [one for one in bag.connections if one.topic in handlers]
        total = sum(one.msgcount for one in wanted)
        first: int | None = None
        for done, (connection, time_ns, data) in enumerate(bag.messages(wanted), start=1):
            first = time_ns if first is None else first
            time_ms = (time_ns - first) / 1e6
            if not 0.0 <= time_ms <= _LONGEST_MS:
                raise ReplayError(f"{path}: must last at most 24 hours, and its times must not decrease")
            try:
                handlers[connection.topic](time_ms, store.deserialize_cdr(data, connection.msgtype))
                end_ms = time_ms
            except Exception as error:  # noqa: BLE001 - damaged bytes may raise anything in rosbags
                left_out += 1
                faults.setdefault(connection.topic, one_line(reason(error)))
            if progress is not None:
                progress(done, total)
    for topic, fault in faults.items():
        if topic.endswith(ALIVE_TURTLES) and not lists:
            raise ReplayError(
                f"{path}: {topic}: its messages must be TurtleArray with string name, float64 x, y, theta; none can "
                f"be read: {fault}"
            )
    if not tracks:
        fault = next((f": {one}" for one in faults.values()), "")
        raise ReplayError(f"{path}: has no pose that can be read{fault}")
    listed = {turtle.name for _, turtles in lists for turtle in turtles}
    hunters = _hunters({name: track for name, track in tracks.items() if name not in listed})
    if not hunters:
        raise ReplayError(f"{path}: has no poses of hunters; record {pose_of(TURTLE)} too")
    return BagContents(hunters, lists, end_ms, left_out)


def _hunters(tracks: Mapping[str, Track]) -> Mapping[str, Track]:
    """Return the hunters' tracks: hunter_0 and so on of `ros serve`, else all of these."""
    own = sorted((name for name in tracks if _OWN_HUNTER.fullmatch(name)), key=lambda name: int(name[7:]))
    return {name: tracks[name] for name in own} or tracks


def _add_pose(tracks: dict[str, Track], name: str, time_ms: float, message: Any) -> None:
    """Add a pose to the track of a turtle."""
    pose = Pose(*(float(getattr(message, part)) for part in Pose._fields))
    inside = all(-_OUTSIDE_M <= place <= TURTLESIM_SIDE_M + _OUTSIDE_M for place in pose[:2])
    if not (inside and all(map(math.isfinite, pose))):
        raise ValueError("a pose lies outside the window")
    track = tracks.setdefault(name, Track())
    track.times_ms.append(time_ms)
    track.poses.append(pose)


def _add_list(lists: list[tuple[float, Sequence[Turtle]]], time_ms: float, message: Any) -> None:
    """Add a list of the targets that are alive."""
    if not all(math.isfinite(number) for one in message.turtles for number in (one.x, one.y, one.theta)):
        raise ValueError("a target's place is not finite")
    turtles = [Turtle(one.name, _clamped(one.x), _clamped(one.y), float(one.theta)) for one in message.turtles]
    lists.append((time_ms, turtles))


def _clamped(place_m: float) -> float:
    """Return a coordinate [m] clamped to turtlesim's window, as turtlesim does for a turtle that is spawned outside."""
    return min(max(float(place_m), 0.0), TURTLESIM_SIDE_M)


@contextmanager
def _opened(path: Path) -> Iterator[Reader]:
    """Open a bag; each error in it becomes one line."""
    try:
        with Reader(path) as bag:
            yield bag
    except ReplayError:
        raise
    except Exception as error:
        there = os.path.exists(path)  # noqa: PTH110 - Path.exists raises an error for a folder without permission
        fault = f"cannot be read as a bag: {one_line(reason(error))}" if there else "no such file"
        raise ReplayError(f"{path}: {fault}") from error


def _handlers(
    path: Path,
    tracks: dict[str, Track],
    lists: list[tuple[float, Sequence[Turtle]]],
    connections: Sequence[Connection],
    store: Typestore,
) -> dict[str, _Handler]:
    """Return a handler for each topic of the game, and register the types of their messages."""
    handlers: dict[str, _Handler] = {}
    list_topics = {connection.topic for connection in connections if connection.msgtype.endswith("/msg/TurtleArray")}
    has_poses = False
    for connection in connections:
        package, _, kind = connection.msgtype.partition("/")
        topic = connection.topic
        if kind == "msg/Pose" and package in {"turtlesim", "turtlesim_msgs"} and topic.endswith(POSE):
            register(store, Interfaces(turtlesim=package).pose)
            handlers[topic] = partial(_add_pose, tracks, topic.strip("/").removesuffix(POSE))
            has_poses = True
        elif topic in list_topics and (topic.endswith(ALIVE_TURTLES) or len(list_topics) == 1):
            _register_list(connection, store)
            handlers[topic] = partial(_add_list, lists)
    if not has_poses:
        raise ReplayError(f"{path}: has no poses of turtlesim; record with ros2 bag record -a")
    return handlers


def _register_list(connection: Connection, store: Typestore) -> None:
    """Register a list's type by the bag's own definition, which may have float32; Humble's SQLite files have none."""
    if connection.msgdef.format == MessageDefinitionFormat.NONE:
        register(store, Interfaces(connection.msgtype.partition("/")[0]).turtle_array)
    else:
        store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
