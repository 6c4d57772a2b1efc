"""Bags as others would read and write them: MCAP record by record from its specification, and rosbags with types that
are written out here.
"""

import struct
from pathlib import Path

from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

MAGIC = b"\x89MCAP0\r\n"
POSE = "float32 x\nfloat32 y\nfloat32 theta\nfloat32 linear_velocity\nfloat32 angular_velocity\n"
TURTLE = "string name\nfloat64 x\nfloat64 y\nfloat64 theta\n"


def mcap(path):
    """The file's schemas and channels by number, and its messages as (channel, ns, data), as they stand in it."""
    content = Path(path).read_bytes()
    assert content.startswith(MAGIC)
    assert content.endswith(MAGIC)
    found = {"schemas": {}, "channels": {}, "messages": [], "statistics": None, "profile": None}
    _records(content[len(MAGIC) : -len(MAGIC)], found)
    return found


def _records(content, found):
    at = 0
    while at < len(content):
        code, size = struct.unpack_from("<BQ", content, at)
        body = content[at + 9 : at + 9 + size]
        at += 9 + size
        if code == 0x01:
            found["profile"] = _texts(body, 2)[0]
        elif code == 0x03:
            (number,) = struct.unpack_from("<H", body)
            found["schemas"][number] = _texts(body[2:], 3)
        elif code == 0x04:
            number, schema = struct.unpack_from("<HH", body)
            found["channels"][number] = (schema, *_texts(body[4:], 2))
        elif code == 0x05:
            channel, _, logged, published = struct.unpack_from("<HIQQ", body)
            assert logged == published
            found["messages"].append((channel, logged, body[22:]))
        elif code == 0x06:
            first, last, whole, _ = struct.unpack_from("<QQQI", body)
            (compression,) = _texts(body[28:], 1)
            assert not compression
            (packed,) = struct.unpack_from("<Q", body, 32)
            assert packed == whole == len(body) - 40
            before = len(found["messages"])
            _records(body[40:], found)
            times = [time for _, time, _ in found["messages"][before:]]
            assert (min(times), max(times)) == (first, last)
        elif code == 0x0B:
            found["statistics"] = struct.unpack_from("<QHIIIIQQ", body)


def _texts(body, count):
    texts, at = [], 0
    for _ in range(count):
        (size,) = struct.unpack_from("<I", body, at)
        texts.append(body[at + 4 : at + 4 + size].decode())
        at += 4 + size
    return texts


_ALWAYS = QosTime(9223372036, 854775807)
_QOS = Qos(
    QosHistory.KEEP_LAST,
    7,
    QosReliability.RELIABLE,
    QosDurability.VOLATILE,
    _ALWAYS,
    _ALWAYS,
    QosLiveliness.AUTOMATIC,
    _ALWAYS,
    avoid_ros_namespace_conventions=False,
)


class Recorder:
    """What `ros2 bag record -a` would have written, by rosbags alone."""

    def __init__(self, folder, storage="sqlite3", package="my_robot_interfaces", turtlesim="turtlesim", turtle=TURTLE):
        self.store = get_typestore(Stores.ROS2_HUMBLE)
        self.pose_type = f"{turtlesim}/msg/Pose"
        self.array_type, self.turtle_type = f"{package}/msg/TurtleArray", f"{package}/msg/Turtle"
        self.store.register(get_types_from_msg(POSE, self.pose_type))
        self.store.register(get_types_from_msg(turtle, self.turtle_type))
        self.store.register(get_types_from_msg(f"{package}/Turtle[] turtles\n", self.array_type))
        self.writer = Writer(folder, version=8, storage_plugin=StoragePlugin[storage.upper()])
        self.topics = {}

    def __enter__(self):
        self.writer.open()
        return self

    def __exit__(self, *error):
        self.writer.close()

    def raw(self, topic, kind, time_ms, data):
        if topic not in self.topics:
            self.topics[topic] = self.writer.add_connection(
                topic, kind, typestore=self.store, offered_qos_profiles=[_QOS]
            )
        self.writer.write(self.topics[topic], 1_700_000_000_000_000_000 + round(time_ms * 1e6), data)

    def pose(self, turtle, time_ms, x, y, theta=0.0, v=0.0, w=0.0):
        message = self.store.types[self.pose_type](x, y, theta, v, w)
        self.raw(f"/{turtle}/pose", self.pose_type, time_ms, self.store.serialize_cdr(message, self.pose_type))

    def alive(self, time_ms, *turtles):
        made = [self.store.types[self.turtle_type](name, x, y, 0.0) for name, x, y in turtles]
        message = self.store.types[self.array_type](made)
        self.raw("/alive_turtles", self.array_type, time_ms, self.store.serialize_cdr(message, self.array_type))


def without_definitions(path):
    """As Humble's files are: no definition of any type stands in them."""
    import sqlite3

    with sqlite3.connect(path) as base:
        base.execute("DELETE FROM message_definitions")
        base.execute("DROP TABLE message_definitions")
        base.execute("UPDATE schema SET schema_version = 3")
        base.execute("ALTER TABLE topics DROP COLUMN type_description_hash")
    base.close()
