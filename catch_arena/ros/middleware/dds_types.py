"""Messages as DDS has them: names, and the types of the package cyclonedds, which make the bytes."""

from functools import cache
from typing import Any, Final

from cyclonedds.idl import make_idl_struct, types
from cyclonedds.idl.annotations import final

from catch_arena.ros.middleware.interfaces import MessageType, values_by_field

_MISSING_MEMBER: Final = "structure_needs_at_least_one_member"
"""The byte that ROS puts into a type without fields."""
_DUMMY: Final = {_MISSING_MEMBER: 0}
_sequence: Final[Any] = types.sequence


def dds_name(kind: MessageType) -> str:
    """Return DDS's name of a type: turtlesim::msg::dds_::Pose_."""
    package, folder, name = kind.name.split("/")
    return f"{package}::{folder}::dds_::{name}_"


def ros_name(topic: str) -> str:
    """Return ROS's name of a DDS topic."""
    return topic[2:].removesuffix("Request" if topic.startswith("rq") else "Reply" if topic.startswith("rr") else "")


@cache
def idl_struct(kind: MessageType, *, header: bool = False) -> Any:
    """Return the package's own type of a message.

    Args:
        kind: the message.
        header: whether it begins with the client's id and a number, as requests and responses do.
    """
    fields: dict[str, Any] = {"client": types.uint64, "number": types.int64} if header else {}
    for name, word, is_sequence in kind.fields:
        one: Any = _idl_type(word) if isinstance(word, str) else idl_struct(word)
        fields[name] = _sequence[one] if is_sequence else one
    if not kind.fields:
        fields[_MISSING_MEMBER] = types.uint8
    return final(make_idl_struct(kind.name.rpartition("/")[2], dds_name(kind), fields))


def _idl_type(word: str) -> Any:
    """Return the package's type of a bool, a string or a number."""
    return {"bool": bool, "string": str}.get(word) or getattr(types, word)


def to_sample(kind: MessageType, message: Any, **header: int) -> Any:
    """Return a message as an object of the package's own type."""
    values = values_by_field(kind, message, to_sample) or _DUMMY
    return idl_struct(kind, header=bool(header))(**header, **values)
