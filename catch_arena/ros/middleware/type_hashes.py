"""What tells two definitions of one type apart: REP 2011's hash, which nodes of Iron and later announce."""

from functools import cache

from catch_arena.ros.middleware.interfaces import MessageType


@cache
def type_hash(kind: MessageType) -> str:
    """RIHS01 and 64 hexadecimal digits; it needs rosbags."""
    from rosbags.typesys.store import Typestore

    from catch_arena.ros.middleware.typestore import register

    store = Typestore()
    register(store, kind)
    return store.hash_rihs01(kind.name)
