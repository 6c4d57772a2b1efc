"""A node that speaks bytes: DDS carries them, and the tests make and read each of them (ros.cdr)."""

from contextlib import suppress
from socket import AF_INET, SOCK_DGRAM, socket
from struct import pack as struct_pack
from types import SimpleNamespace

from cyclonedds._clayer import ddspy_take, ddspy_write
from cyclonedds.core import DDSException, Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.idl.annotations import final
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
_VECTOR = struct("geometry_msgs::msg::dds_::Vector3_", x=_D, y=_D, z=_D)
_DUMMY = {"structure_needs_at_least_one_member": types.uint8}
TWIST = struct("geometry_msgs::msg::dds_::Twist_", linear=_VECTOR, angular=_VECTOR)
POSE = struct("turtlesim::msg::dds_::Pose_", x=_F, y=_F, theta=_F, linear_velocity=_F, angular_velocity=_F)


def turtles():
    turtle = struct("my_robot_interfaces::msg::dds_::Turtle_", name=str, x=_D, y=_D, theta=_D)
    return struct("my_robot_interfaces::msg::dds_::TurtleArray_", turtles=types.sequence[turtle])


def catch_turtle():
    kind = "my_robot_interfaces::srv::dds_::CatchTurtle"
    return struct(f"{kind}_Request_", **_HEAD, name=str), struct(f"{kind}_Response_", **_HEAD, success=bool)


SPAWN = (
    struct("turtlesim::srv::dds_::Spawn_Request_", **_HEAD, x=_F, y=_F, theta=_F, name=str),
    struct("turtlesim::srv::dds_::Spawn_Response_", **_HEAD, name=str),
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
        """Return functions that send bytes."""
        made = DataWriter(self.participant, Topic(self.participant, topic, kind), qos=QOS)

        def write(data):
            assert ddspy_write(made._ref, data + bytes(-len(data) % 4)) == 0

        def inject(domain, number, data):
            """Send a sample as a packet of its own, which no library has checked, to every process on this machine."""
            guid = made.guid.bytes
            body = struct_pack("<HH4x4siI", 0, 16, guid[12:], 0, number) + data
            packet = b"RTPS\x02\x05\x01\x10" + guid[:12] + struct_pack("<BBH", 0x15, 5, len(body)) + body
            with socket(AF_INET, SOCK_DGRAM) as sender:
                for place in range(20):
                    sender.sendto(packet, ("127.0.0.1", 7400 + 250 * domain + 11 + 2 * place))

        return SimpleNamespace(
            write=write,
            inject=inject,
            matched=lambda: len(made.get_matched_subscriptions()),
            handle=made.get_instance_handle() % 2**64,
            keep=made,
        )

    def reader(self, topic, kind):
        """Return functions that take bytes."""
        made = DataReader(self.participant, Topic(self.participant, topic, kind), qos=QOS)

        def take():
            found = ddspy_take(made._ref, 0b1111111, 100)
            assert not isinstance(found, int), found
            return [bytes(data) for data, info in found if info.valid_data]

        return SimpleNamespace(take=take, matched=lambda: len(made.get_matched_publications()), keep=made)

    def client(self, service, kinds):
        """Return both ends of a client: its writer and its reader."""
        asks, answers = kinds
        return self.writer(f"rq{service}Request", asks), self.reader(f"rr{service}Reply", answers)

    def server(self, service, kinds):
        """Return both ends of a server: its reader and its writer."""
        asks, answers = kinds
        return self.reader(f"rq{service}Request", asks), self.writer(f"rr{service}Reply", answers)
