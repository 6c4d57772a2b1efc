"""Bags of rosbag2 as files, written by the library rosbags: a folder with metadata.yaml and one MCAP or SQLite file.

A bag holds the definitions of its types, so that its readers need no others.
"""

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, Literal

from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from catch_arena.errors import OutputError
from catch_arena.files import prepare_folder, unwritable
from catch_arena.ros.middleware.interfaces import MessageType
from catch_arena.ros.middleware.typestore import register

Storage = Literal["mcap", "sqlite3"]

_METADATA_VERSION: Final = 8
"""The last version that Humble reads; 9 writes the quality of service in a way that Humble does not read."""
_METADATA: Final = "metadata.yaml"


class BagWriter:
    """Writer of messages to an open bag; each topic is announced before its first message."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self._store = get_typestore(Stores.ROS2_JAZZY)
        self._connections: dict[str, Any] = {}
        self.messages = 0
        """Number of messages that have been written."""

    def announce(self, topic: str, kind: MessageType) -> None:
        """Add a topic of messages."""
        register(self._store, kind)
        self._connections[topic] = self._writer.add_connection(topic, kind.name, typestore=self._store)

    def make(self, kind: str, *fields: Any) -> Any:
        """Return a message of a type that was announced, to stand in a field of another one."""
        return self._store.types[kind](*fields)

    def write(self, topic: str, time_ms: int, *fields: Any) -> None:
        """Write one message, given by the values of its fields."""
        connection = self._connections[topic]
        message = self.make(connection.msgtype, *fields)
        self._writer.write(connection, time_ms * 1_000_000, self._store.serialize_cdr(message, connection.msgtype))
        self.messages += 1


@contextmanager
def whole_bag(folder: Path, storage: Storage, *, force: bool) -> Iterator[BagWriter]:
    """Open a bag under a temporary name, which is renamed when everything has been written.

    Args:
        folder: the bag's folder.
        storage: the kind of its file.
        force: whether it may replace a bag that exists.

    Raises:
        OutputError: if it cannot be written, and before the first message if the folder is not free.
    """
    target = Path(os.path.realpath(folder))
    _require_free(folder, target, force=force)
    prepare_folder(target.parent)
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".catch-arena-") as scratch:
        made = Path(scratch) / target.name  # rosbags gives the file in it the folder's name
        try:
            with Writer(made, version=_METADATA_VERSION, storage_plugin=plugin) as writer:
                yield BagWriter(writer)
            if target.exists():
                shutil.copymode(target, made)
                target.rename(Path(scratch) / "replaced")  # removed with the scratch folder
            made.rename(target)
        except OSError as error:
            raise unwritable(folder, error) from None


def _require_free(folder: Path, target: Path, *, force: bool) -> None:
    if not target.exists() or (target.is_dir() and not any(target.iterdir())):
        return
    if not (target / _METADATA).is_file():
        raise OutputError(f"{folder}: already exists and is not a bag; choose another name")
    if not force:
        raise OutputError(f"{folder}: already exists; use --force to replace it, or choose another name")
