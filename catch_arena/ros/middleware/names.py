"""Names of back-ends and packages, for command-line options, which must not load a back-end."""

from typing import Final, Literal, get_args

Backend = Literal["rclpy", "cyclonedds", "rosbridge"]
BACKENDS: Final[tuple[Backend, ...]] = get_args(Backend)
"""Back-ends in the order in which they are tried."""
BRIDGE_URL: Final = "ws://127.0.0.1:9090"
"""Usual address of rosbridge's server."""
INTERFACES: Final = "my_robot_interfaces"
"""The exercise's package, with Turtle, TurtleArray and CatchTurtle."""
TURTLESIM: Final = "turtlesim"
"""The package with Pose; turtlesim_msgs from Kilted on."""
