"""Bags as `ros2 bag record` writes them, made by rosbags with types that are written out here."""

import sqlite3

from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

POSE = "float32 x\nfloat32 y\nfloat32 theta\nfloat32 linear_velocity\nfloat32 angular_velocity\n"
TURTLE = "string name\nfloat64 x\nfloat64 y\nfloat64 theta\n"


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
    """Writer of what `ros2 bag record -a` would have written."""

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
    """Turn a SQLite file into one of Humble, without the definition of any type."""
    with sqlite3.connect(path) as base:
        base.execute("DELETE FROM message_definitions")
        base.execute("DROP TABLE message_definitions")
        base.execute("UPDATE schema SET schema_version = 3")
        base.execute("ALTER TABLE topics DROP COLUMN type_description_hash")
    base.close()
