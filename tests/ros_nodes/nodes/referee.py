"""The exercise's spawner, which publishes /alive_turtles and serves /catch_turtle; with `--judges` an arbiter alone."""

import argparse
import math
import sys

import rclpy
from my_robot_interfaces.msg import Turtle, TurtleArray
from my_robot_interfaces.srv import CatchTurtle
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from turtlesim.msg import Pose
from turtlesim.srv import Spawn


class Spawner(Node):
    """Spawns turtles, and says yes to every request."""

    def __init__(self):
        super().__init__("turtle_spawner")
        self.turtles = []
        self.publisher = self.create_publisher(TurtleArray, "alive_turtles", 10)
        self.spawn = self.create_client(Spawn, "/spawn")
        self.create_service(CatchTurtle, "catch_turtle", self.on_request)
        self.create_timer(1.0, self.on_timer)

    def on_timer(self):
        self.turtles.append(Turtle(name=f"t{len(self.turtles)}", x=1.0, y=1.0))
        self.publisher.publish(TurtleArray(turtles=self.turtles))

    def on_request(self, request, response):
        self.turtles = [one for one in self.turtles if one.name != request.name]
        response.success = True
        return response


class Judge(Node):
    """Grants a target that is listed, was not caught, and is in reach of turtle1."""

    def __init__(self, reach_m):
        super().__init__("arbiter")
        self.reach_um = round(reach_m * 1e6)
        self.pose, self.turtles, self.caught = Pose(), {}, set()
        self.create_subscription(Pose, "/turtle1/pose", self.on_pose, 10)
        self.create_subscription(TurtleArray, "/alive_turtles", self.on_list, 10)
        self.create_service(CatchTurtle, "/catch_turtle", self.on_request)

    def on_pose(self, pose):
        self.pose = pose

    def on_list(self, message):
        self.turtles = {one.name: one for one in message.turtles}

    def on_request(self, request, response):
        turtle = self.turtles.get(request.name)
        if turtle is not None and request.name not in self.caught and len(request.name) <= 255:
            metres = math.hypot(turtle.x - self.pose.x, turtle.y - self.pose.y)
            response.success = math.floor(metres * 1e6 + 0.5) < self.reach_um
        if response.success:
            self.caught.add(request.name)
        return response


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--judges", type=float, metavar="METRES")
    rclpy.init()
    metres = parser.parse_args(rclpy.utilities.remove_ros_args()[1:]).judges
    try:
        rclpy.spin(Spawner() if metres is None else Judge(metres))
    except (KeyboardInterrupt, ExternalShutdownException):
        sys.exit()
