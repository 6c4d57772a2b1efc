"""What tells two definitions of one type apart: REP 2011's hash, which nodes of Iron and later announce."""

from functools import cache
from typing import TYPE_CHECKING

from catch_arena.ros.middleware.interfaces import MessageType

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore


@cache
def type_hash(kind: MessageType) -> str:
    """RIHS01 and 64 hexadecimal digits; it needs rosbags."""
    from rosbags.typesys.store import Typestore

    store = Typestore()
    register(store, kind)
    return store.hash_rihs01(kind.name)


def register(store: "Typestore", kind: MessageType) -> None:
    """Make a type known to rosbags, with all that it holds."""
    from rosbags.typesys import get_types_from_msg

    for field in kind.fields:
        if isinstance(field.type, MessageType):
            register(store, field.type)
    if kind.name not in store.types:
        store.register(get_types_from_msg(kind.definition, kind.name))
