"""Calls of a service as ROS records them from Iron on: the topic `/SERVICE/_service_event` of `PACKAGE/srv/S_Event`."""

from typing import Any, Final, NamedTuple

from catch_arena.ros.middleware.interfaces import TIME, Field, MessageType, ServiceType, Time

TOPIC: Final = "/_service_event"
"""What the name of a service's topic ends in."""
REQUEST_SENT, REQUEST_RECEIVED, RESPONSE_SENT, RESPONSE_RECEIVED = range(4)
"""What happened: at the client, at the server, at the server, at the client."""


class EventInfo(NamedTuple):
    """service_msgs/msg/ServiceEventInfo."""

    event_type: int
    stamp: Time
    client_gid: bytes
    """Sixteen; with the number they say which response belongs to which request."""
    sequence_number: int


class ServiceEvent(NamedTuple):
    """What happened, and the request or the response, whichever it is."""

    info: EventInfo
    request: tuple[Any, ...]
    """One or none."""
    response: tuple[Any, ...]
    """One or none."""


EVENT_INFO: Final = MessageType(
    "service_msgs/msg/ServiceEventInfo",
    EventInfo,
    (
        Field("event_type", "uint8", is_sequence=False),
        Field("stamp", TIME, is_sequence=False),
        Field("client_gid", "uint8", is_sequence=True),
        Field("sequence_number", "int64", is_sequence=False),
    ),
)


def event_of(service: ServiceType) -> MessageType:
    """The message that tells a service's calls."""
    return MessageType(
        f"{service.name}_Event",
        ServiceEvent,
        (
            Field("info", EVENT_INFO, is_sequence=False),
            Field("request", service.request, is_sequence=True),
            Field("response", service.response, is_sequence=True),
        ),
    )
