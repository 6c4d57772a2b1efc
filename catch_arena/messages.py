"""Rulebook R8.1: the interfaces of the ROS 2 exercise, as plain typed messages with the field names of its packages."""

from typing import NamedTuple


class Turtle(NamedTuple):
    """my_robot_interfaces/msg/Turtle: one alive target in m; theta in rad in [0, 2 pi), as requested at its spawn."""

    name: str
    x: float
    y: float
    theta: float


class TurtleArray(NamedTuple):
    """my_robot_interfaces/msg/TurtleArray: the alive targets in spawning order (R8.2)."""

    turtles: tuple[Turtle, ...]


class CatchTurtleRequest(NamedTuple):
    """my_robot_interfaces/srv/CatchTurtle, the request: name of the target to catch."""

    name: str


class CatchTurtleResponse(NamedTuple):
    """my_robot_interfaces/srv/CatchTurtle, the response: true only if the verdict is GRANTED (R5.2)."""

    success: bool


class Pose(NamedTuple):
    """turtlesim/msg/Pose: pose and velocities of a turtle, in m, m/s, rad/s; theta in rad in [-pi, pi)."""

    x: float
    y: float
    theta: float
    linear_velocity: float
    angular_velocity: float


class Twist(NamedTuple):
    """The two fields of geometry_msgs/msg/Twist that a turtle obeys: linear.x [m/s] and angular.z [rad/s]."""

    linear_x: float
    angular_z: float
