"""Export of a recorded match as a bag, with the messages that a ROS 2 bus would have carried while it was played.

The library rosbags writes it: a folder with metadata.yaml and one MCAP or SQLite file. A bag holds the definitions of
its types, so that its readers need no others.
"""

import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, Literal

from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from catch_arena.core.physics import TICK_MS
from catch_arena.errors import OutputError
from catch_arena.files import prepare_folder, unwritable
from catch_arena.replay import Replay
from catch_arena.replay.motion import Poses, poses_of, step_motion
from catch_arena.ros.middleware.graph_names import ALIVE_TURTLES, RULINGS, TURTLE, pose_of
from catch_arena.ros.middleware.interfaces import RULING, Interfaces, RulingMessage
from catch_arena.ros.middleware.typestore import register
from catch_arena.verdicts import Ruling
from catch_arena.world import HunterState, TargetState, World

Storage = Literal["mcap", "sqlite3"]

_METADATA_VERSION: Final = 8
"""The last version that Humble reads; 9 writes the quality of service in a way that Humble does not read."""


def export_bag(
    replay: Replay,
    folder: Path,
    storage: Storage,
    interfaces: Interfaces,
    *,
    force: bool,
    progress: Callable[[int, int], None],
) -> int:
    """Write a match as a bag, and return the number of its messages; `force` replaces a bag that exists.

    `progress` is called with (steps written, steps in all). If the bag cannot be written, nothing unfinished is left.
    """
    with _whole_bag(folder, storage, force=force) as bag:
        match = _MatchWriter(bag, replay, interfaces)
        first = next(replay.worlds())
        match.write_poses(0, first.hunters, poses_of(first))
        match.write_alive(0, first.targets, poses_of(first))
        for before, after, by_name in replay.judged_steps():
            match.write_step(before, after, by_name)
            progress(after.step, replay.steps)
        return match.messages


class _MatchWriter:
    """Writer of one match; times are milliseconds of the match. A single hunter has the exercise's name, turtle1."""

    def __init__(self, bag: Writer, replay: Replay, interfaces: Interfaces) -> None:
        self._bag, self._replay = bag, replay
        self._types = get_typestore(Stores.ROS2_JAZZY)
        self._connections: dict[str, Any] = {}
        self.messages = 0
        self._hunters = replay.config.hunter_names
        self._poses = [pose_of(turtle) for turtle in ([TURTLE] if len(self._hunters) == 1 else self._hunters)]
        topics = dict.fromkeys(self._poses, interfaces.pose)
        for topic, kind in (topics | {ALIVE_TURTLES: interfaces.turtle_array, RULINGS: RULING}).items():
            register(self._types, kind)
            self._connections[topic] = bag.add_connection(topic, kind.name, typestore=self._types)
        self._turtle = self._types.types[interfaces.turtle.name]

    def write_step(self, before: World, after: World, by_name: Sequence[Ruling]) -> None:
        """Write one step. R1.4: its requests are judged on the state at its beginning; then comes the motion."""
        motion = step_motion(before, after)
        for ruling in (*after.rulings, *by_name):
            self._write(RULINGS, before.time_ms, *RulingMessage.of(ruling, before.time_ms, self._hunters))
        if {target.number for target in before.targets} - {target.number for target in after.targets}:
            self.write_alive(before.time_ms, after.targets, motion.poses[0])
        first = before.time_ms // TICK_MS
        lists = {target.spawned_ms for target in after.targets if target.spawned_ms > before.time_ms}
        if self._replay.config.targets_move and after.targets:
            lists.add(after.time_ms)
        for time_ms in sorted({*lists, *range((first + 1) * TICK_MS, after.time_ms + 1, TICK_MS)}):
            poses = motion.poses[min(time_ms // TICK_MS - first, len(motion.poses) - 1)]
            if time_ms % TICK_MS == 0:
                self.write_poses(time_ms, after.hunters, poses)
            if time_ms in lists:
                self.write_alive(time_ms, after.targets, poses)

    def write_poses(self, time_ms: int, hunters: Sequence[HunterState], poses: Poses) -> None:
        """Write the pose of each hunter."""
        for topic, hunter, pose in zip(self._poses, hunters, poses.hunters, strict=True):
            self._write(topic, time_ms, *pose, *hunter.pose[3:])

    def write_alive(self, time_ms: int, targets: Sequence[TargetState], poses: Poses) -> None:
        """R8.2: write the list of the targets that have appeared."""
        alive = [target for target in targets if target.spawned_ms <= time_ms]
        turtles = [self._turtle(target.name, *poses.targets[target.number]) for target in alive]
        self._write(ALIVE_TURTLES, time_ms, turtles)

    def _write(self, topic: str, time_ms: int, *fields: Any) -> None:
        """Write one message, given by the values of its fields."""
        connection = self._connections[topic]
        message = self._types.types[connection.msgtype](*fields)
        self._bag.write(connection, time_ms * 1_000_000, self._types.serialize_cdr(message, connection.msgtype))
        self.messages += 1


@contextmanager
def _whole_bag(folder: Path, storage: Storage, *, force: bool) -> Iterator[Writer]:
    """Open a bag under a temporary name, which is renamed when everything has been written."""
    target = Path(os.path.realpath(folder))
    _require_free(folder, target, force=force)
    prepare_folder(target.parent)
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".catch-arena-") as scratch:
        made = Path(scratch) / target.name  # rosbags gives the file in it the folder's name
        try:
            with Writer(made, version=_METADATA_VERSION, storage_plugin=plugin) as writer:
                yield writer
            if target.exists():
                shutil.copymode(target, made)
                target.rename(Path(scratch) / "replaced")  # removed with the scratch folder
            made.rename(target)
        except OSError as error:
            raise unwritable(folder, error) from None


def _require_free(folder: Path, target: Path, *, force: bool) -> None:
    if not target.exists() or (target.is_dir() and not any(target.iterdir())):
        return
    if not (target / "metadata.yaml").is_file():
        raise OutputError(f"{folder}: already exists and is not a bag; choose another name")
    if not force:
        raise OutputError(f"{folder}: already exists; use --force to replace it, or choose another name")
