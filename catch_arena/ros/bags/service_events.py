"""Recorded calls of a service, as ROS has them from Iron on: topic `/SERVICE/_service_event`, type `.../S_Event`."""

from typing import Final

from rosbags.typesys import get_types_from_idl
from rosbags.typesys.store import Typestore

TOPIC: Final = "/_service_event"
"""End of the name of a topic that has a service's calls."""
REQUEST_SENT, REQUEST_RECEIVED, RESPONSE_SENT, RESPONSE_RECEIVED = range(4)
"""Event types: at the client, at the server, at the server, at the client."""
EVENT_INFO: Final = "service_msgs/msg/ServiceEventInfo"
TIME: Final = "builtin_interfaces/msg/Time"
_SEPARATOR: Final = "=" * 80 + "\n"
_IDL: Final = """\
================================================================================
IDL: PACKAGE/srv/CatchTurtle_Event
module PACKAGE { module srv { struct CatchTurtle_Event { service_msgs::msg::ServiceEventInfo info; \
sequence<PACKAGE::srv::CatchTurtle_Request, 1> request; sequence<PACKAGE::srv::CatchTurtle_Response, 1> response; \
}; }; };
================================================================================
IDL: PACKAGE/srv/CatchTurtle_Request
module PACKAGE { module srv { struct CatchTurtle_Request { string name; }; }; };
================================================================================
IDL: PACKAGE/srv/CatchTurtle_Response
module PACKAGE { module srv { struct CatchTurtle_Response { boolean success; }; }; };
================================================================================
IDL: service_msgs/msg/ServiceEventInfo
module service_msgs { module msg { struct ServiceEventInfo {
uint8 event_type; builtin_interfaces::msg::Time stamp; char client_gid[16]; int64 sequence_number; }; }; };
================================================================================
IDL: builtin_interfaces/msg/Time
module builtin_interfaces { module msg { struct Time { int32 sec; uint32 nanosec; }; }; };
"""


def event_type(package: str) -> str:
    """Return the name of the type of a catch service's recorded calls."""
    return f"{package}/srv/CatchTurtle_Event"


def event_definition(package: str) -> str:
    """Return the definition of `event_type(package)` and of the types in it, in IDL as rosbag2 writes it."""
    return _IDL.replace("PACKAGE", package)


def register_idl(store: Typestore, definition: str) -> None:
    """Register every type of a definition in IDL; where it has several, a header `IDL: NAME` stands before each."""
    for part in definition.split(_SEPARATOR):
        idl = part.partition("\n")[2] if part.startswith("IDL: ") else part
        if idl:
            store.register(get_types_from_idl(idl))
