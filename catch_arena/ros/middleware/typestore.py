"""Our types as the library rosbags has them, and their hashes."""

from functools import cache

from rosbags.typesys import get_types_from_msg
from rosbags.typesys.store import Typestore

from catch_arena.ros.middleware.interfaces import MessageType


def register(store: Typestore, kind: MessageType) -> None:
    """Add a type, and those in it, to a type store that does not have them."""
    for field in kind.fields:
        if isinstance(field.type, MessageType):
            register(store, field.type)
    if kind.name not in store.fielddefs:
        store.register(get_types_from_msg(kind.definition, kind.name))


@cache
def type_hash(kind: MessageType) -> str:
    """Return the hash of a definition (REP 2011), which nodes of Iron and later announce."""
    store = Typestore()
    register(store, kind)
    return store.hash_rihs01(kind.name)
