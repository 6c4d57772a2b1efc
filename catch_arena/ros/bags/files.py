"""Recordings of rosbag2 as files, by the library rosbags: a folder with metadata.yaml and one file, MCAP or SQLite.

What is written says of itself how its messages are read: it holds the definitions of their types.
"""

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, Literal, NamedTuple

import numpy as np
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from catch_arena.errors import OutputError
from catch_arena.files import prepare_folder, unwritable
from catch_arena.ros.bags.service_events import EVENT_INFO
from catch_arena.ros.middleware.bus import DEPTH
from catch_arena.ros.middleware.interfaces import TIME, MessageType, values_by_field
from catch_arena.ros.middleware.typestore import register

Storage = Literal["mcap", "sqlite3"]

_METADATA_VERSION: Final = 8
"""Humble reads what it knows of it, and Jazzy all; 9 writes the quality of service in a way that Humble cannot read."""
_METADATA: Final = "metadata.yaml"
_EVENT_INFO_IDL: Final = """module service_msgs { module msg { struct ServiceEventInfo {
uint8 event_type; builtin_interfaces::msg::Time stamp; char client_gid[16]; int64 sequence_number; }; }; };
"""
_IDL_WORDS: Final = {"bool": "boolean", "float32": "float", "float64": "double"}
_FOREVER: Final = QosTime(9223372036, 854775807)
_QOS: Final = Qos(
    QosHistory.KEEP_LAST,
    DEPTH,
    QosReliability.RELIABLE,
    QosDurability.VOLATILE,
    _FOREVER,
    _FOREVER,
    QosLiveliness.AUTOMATIC,
    _FOREVER,
    avoid_ros_namespace_conventions=False,
)
"""ROS's usual one, as turtlesim and the exercise have it."""


class TimedMessage(NamedTuple):
    """One message of a bag."""

    time_ns: int
    """As a bag counts: since 1970, or since a match began."""
    topic: str
    kind: MessageType
    message: Any


class BagWriter:
    """Writes messages; their topics are announced as they come."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self._store = get_typestore(Stores.ROS2_JAZZY)
        self._connections: dict[str, Any] = {}

    def announce(self, topic: str, kind: MessageType) -> None:
        """A topic that is there even if nothing is said on it."""
        if topic not in self._connections:
            register(self._store, kind)
            self._connections[topic] = self._writer.add_connection(
                topic,
                kind.name,
                msgdef=self._definition(kind),
                rihs01=self._store.hash_rihs01(kind.name),
                offered_qos_profiles=[_QOS],
            )

    def write(self, one: TimedMessage) -> None:
        """One message."""
        self.announce(one.topic, one.kind)
        data = self._store.serialize_cdr(self._made(one.kind, one.message), one.kind.name)
        self._writer.write(self._connections[one.topic], one.time_ns, data)

    def _definition(self, kind: MessageType) -> str:
        """The text of a type's definition and of those in it, as rosbag2 has it: in IDL those that are no messages,
        since the other language has no names for them.
        """
        if "/msg/" in kind.name:
            return str(self._store.generate_msgdef(kind.name, ros_version=2)[0])
        parts = [word for _, word, _ in kind.fields if isinstance(word, MessageType) and word is not EVENT_INFO]
        texts = {part.name: _idl(part) for part in (kind, *parts)}  # readers take the first for the whole
        texts |= {EVENT_INFO.name: _EVENT_INFO_IDL, TIME.name: _idl(TIME)}
        return "".join(f"{'=' * 80}\nIDL: {name}\n{text}" for name, text in texts.items())

    def _made(self, kind: MessageType, message: Any) -> Any:
        """A message as rosbags takes it."""
        values = values_by_field(kind, message, self._made)
        arrays = {name: np.frombuffer(one, np.uint8) for name, one in values.items() if isinstance(one, bytes)}
        return self._store.types[kind.name](**values | arrays)


def _idl(kind: MessageType) -> str:
    """A type as IDL; its sequences hold one thing at most, as those of a service's events do."""
    fields = []
    for name, word, is_sequence in kind.fields:
        text = _IDL_WORDS.get(word, word) if isinstance(word, str) else word.name.replace("/", "::")
        fields.append(f"sequence<{text}, 1> {name};" if is_sequence else f"{text} {name};")
    package, group, name = kind.name.split("/")
    return f"module {package} {{ module {group} {{ struct {name} {{ {' '.join(fields)} }}; }}; }};\n"


@contextmanager
def whole_bag(folder: Path, storage: Storage, *, force: bool) -> Iterator[BagWriter]:
    """A bag under a temporary name, which is renamed when all has been written.

    Args:
        folder: where it will be.
        storage: the kind of its file.
        force: whether it takes the place of a bag that is there.

    Raises:
        OutputError: where it cannot be written.
    """
    require_free(folder, force=force)
    target = Path(os.path.realpath(folder))
    prepare_folder(target.parent)
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".catch-arena-") as scratch:
        made = Path(scratch) / target.name  # its file is called as the folder is
        try:
            writer = Writer(
                made,
                version=_METADATA_VERSION,
                storage_plugin=StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3,
            )
            writer.open()
            try:
                yield BagWriter(writer)
            except BaseException:
                writer.abort()
                raise
            writer.close()
            if target.exists():
                shutil.copymode(target, made)
                target.rename(Path(scratch) / "replaced")  # and goes with the scratch
            made.rename(target)
        except OSError as error:
            raise unwritable(folder, error) from None


def require_free(folder: Path, *, force: bool) -> None:
    """Before the work: whether a bag can be written there.

    Raises:
        OutputError: where something else is there, or a bag that may not be replaced.
    """
    target = Path(os.path.realpath(folder))
    if not target.exists():
        return
    if not target.is_dir() or (any(target.iterdir()) and not (target / _METADATA).is_file()):
        raise OutputError(f"{folder}: is there already, and is no bag: give another name")
    if any(target.iterdir()) and not force:
        raise OutputError(f"{folder}: is there already: give --force to replace it, or another name")
