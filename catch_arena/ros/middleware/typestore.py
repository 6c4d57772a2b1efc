"""Our types as the library rosbags knows types."""

from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys.store import Typestore

from catch_arena.ros.middleware.interfaces import MessageType


def register(store: Typestore, kind: MessageType) -> None:
    """Make a type, and those in it, known to a type store, unless it knows them."""
    if kind.name in store.fielddefs:
        return
    lines: list[Any] = []
    for name, word, is_sequence in kind.fields:
        if isinstance(word, str):
            node: Any = (Nodetype.BASE, (word, 0))
        else:
            register(store, word)
            node = (Nodetype.NAME, word.name)
        most = 1 if kind.name.endswith("_Event") else 0  # 0: as many as there are
        lines.append((name, (Nodetype.SEQUENCE, (node, most)) if is_sequence else node))
    store.register({kind.name: ([], lines)})
