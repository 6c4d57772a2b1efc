"""A node that knows DDS and no code of ours: its types are written out by hand."""

from contextlib import suppress
from types import SimpleNamespace

from cyclonedds._clayer import ddspy_write
from cyclonedds.core import DDSException, Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.idl.annotations import final
from cyclonedds.internal import InvalidSample
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

LOOPBACK = """<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>120</MaxAutoParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>"""
QOS = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)),
    Policy.History.KeepLast(10),
    Policy.DataRepresentation(use_cdrv0_representation=True),
    Policy.WriterDataLifecycle(autodispose=False),
)


def struct(name, /, **fields):
    return final(make_idl_struct(name.rpartition("::")[2], name, fields))


_F, _D, _HEAD = types.float32, types.float64, {"client": types.uint64, "number": types.int64}
VECTOR = struct("geometry_msgs::msg::dds_::Vector3_", x=_D, y=_D, z=_D)
_DUMMY = {"structure_needs_at_least_one_member": types.uint8}
TWIST = struct("geometry_msgs::msg::dds_::Twist_", linear=VECTOR, angular=VECTOR)
POSE = struct("turtlesim::msg::dds_::Pose_", x=_F, y=_F, theta=_F, linear_velocity=_F, angular_velocity=_F)


TURTLE = struct("my_robot_interfaces::msg::dds_::Turtle_", name=str, x=_D, y=_D, theta=_D)
TURTLES = struct("my_robot_interfaces::msg::dds_::TurtleArray_", turtles=types.sequence[TURTLE])
CATCH_TURTLE = (
    struct("my_robot_interfaces::srv::dds_::CatchTurtle_Request_", **_HEAD, name=str),
    struct("my_robot_interfaces::srv::dds_::CatchTurtle_Response_", **_HEAD, success=bool),
)
KILL = (
    struct("turtlesim::srv::dds_::Kill_Request_", **_HEAD, name=str),
    struct("turtlesim::srv::dds_::Kill_Response_", **_HEAD, **_DUMMY),
)
_domains = {}


class Node:
    """A participant on the loopback interface."""

    def __init__(self, domain):
        if domain not in _domains:
            with suppress(DDSException):  # this process has it already
                _domains[domain] = Domain(domain, LOOPBACK)
        self.participant = DomainParticipant(domain)

    def writer(self, topic, kind):
        """Return functions that send a message, by its fields or as bytes."""
        made = DataWriter(self.participant, Topic(self.participant, topic, kind), qos=QOS)
        return SimpleNamespace(
            write=lambda *fields: made.write(kind(*fields)),
            write_bytes=lambda data: ddspy_write(made._ref, data + bytes(-len(data) % 4)),
            matched=lambda: len(made.get_matched_subscriptions()),
            handle=made.get_instance_handle() % 2**64,
            keep=made,
        )

    def reader(self, topic, kind):
        """Return functions that take messages."""
        made = DataReader(self.participant, Topic(self.participant, topic, kind), qos=QOS)
        return SimpleNamespace(
            take=lambda: [one for one in made.take(100) if not isinstance(one, InvalidSample)],
            matched=lambda: len(made.get_matched_publications()),
            keep=made,
        )

    def client(self, service, kinds):
        """Return both ends of a client: its writer and its reader."""
        request_type, reply_type = kinds
        return self.writer(f"rq{service}Request", request_type), self.reader(f"rr{service}Reply", reply_type)

    def server(self, service, kinds):
        """Return both ends of a server: its reader and its writer."""
        request_type, reply_type = kinds
        return self.reader(f"rq{service}Request", request_type), self.writer(f"rr{service}Reply", reply_type)


def twist(linear_x, angular_z):
    return VECTOR(linear_x, 0.0, 0.0), VECTOR(0.0, 0.0, angular_z)


def listed(*turtles):
    return [TURTLE(*one) for one in turtles]
