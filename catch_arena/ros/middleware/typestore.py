"""Our types as the library rosbags has them, and their hashes."""

from functools import cache
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys.store import Typestore

from catch_arena.ros.middleware.interfaces import MessageType


def register(store: Typestore, kind: MessageType) -> None:
    """Add a type, and those in it, to a type store that does not have them."""
    if kind.name in store.fielddefs:
        return
    lines: list[Any] = []
    for name, word, is_sequence in kind.fields:
        if isinstance(word, str):
            node: Any = (Nodetype.BASE, (word, 0))
        else:
            register(store, word)
            node = (Nodetype.NAME, word.name)
        lines.append((name, (Nodetype.SEQUENCE, (node, 0)) if is_sequence else node))  # 0: of any length
    store.register({kind.name: ([], lines)})


@cache
def type_hash(kind: MessageType) -> str:
    """Return the hash of a definition (REP 2011), which nodes of Iron and later announce."""
    store = Typestore()
    register(store, kind)
    return store.hash_rihs01(kind.name)
