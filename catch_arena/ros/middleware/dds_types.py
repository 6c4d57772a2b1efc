"""Messages as DDS has them: names, and the types of the package cyclonedds, which make the bytes."""

from functools import cache
from typing import Any, Final

from cyclonedds.idl import make_idl_struct, types
from cyclonedds.idl.annotations import final

from catch_arena.ros.middleware.interfaces import PRIMITIVES, MessageType, values_by_field

_MISSING_MEMBER: Final = "structure_needs_at_least_one_member"
"""The byte that ROS puts into what has no fields."""
_DUMMY: Final = {_MISSING_MEMBER: 0}
_PRIMITIVES: Final[dict[str, Any]] = {word: getattr(types, word, None) for word in PRIMITIVES} | {
    "bool": bool,
    "string": str,
}
_sequence: Final[Any] = types.sequence
MOST_ASKED: Final = 16
"""Elements that a sequence of a request may have: DDS leaves out what has more, before it takes time to read."""


def dds_name(kind: MessageType) -> str:
    """What DDS calls a type: turtlesim::msg::dds_::Pose_."""
    package, folder, name = kind.name.split("/")
    return f"{package}::{folder}::dds_::{name}_"


def ros_name(topic: str) -> str:
    """A DDS topic as ROS calls it."""
    return topic[2:].removesuffix("Request" if topic.startswith("rq") else "Reply" if topic.startswith("rr") else "")


@cache
def idl_struct(kind: MessageType, *, header: bool = False, bounded: bool = False) -> Any:
    """The package's own type of a message.

    Args:
        kind: the message.
        header: with what a request or a response begins with.
        bounded: whether it is a part of a request.
    """
    bounded = bounded or kind.name.endswith("_Request")
    fields: dict[str, Any] = {"client": types.uint64, "number": types.int64} if header else {}
    for name, word, is_sequence in kind.fields:
        one: Any = _PRIMITIVES[word] if isinstance(word, str) else idl_struct(word, bounded=bounded)
        if is_sequence:
            one = _sequence[one, MOST_ASKED] if bounded else _sequence[one]
        fields[name] = one
    if not kind.fields:
        fields[_MISSING_MEMBER] = types.uint8
    return final(make_idl_struct(kind.name.rpartition("/")[2], dds_name(kind), fields))


def to_sample(kind: MessageType, message: Any, **header: int) -> Any:
    """A message as the package wants it."""
    values = values_by_field(kind, message, to_sample) or _DUMMY
    return idl_struct(kind, header=bool(header))(**header, **values)
