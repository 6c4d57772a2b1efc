"""The exercise's controller, as different people write it: its arguments are the choices in which solutions differ.

Prints "caught NAME" and "refused NAME" for each answer.
"""

import argparse
import math
import sys
from importlib import import_module

import rclpy
from geometry_msgs.msg import Twist
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from turtlesim.msg import Pose
from turtlesim.srv import SetPen


class Controller(Node):
    """Drives to one target after the other, and asks for it when it is near."""

    def __init__(self, choices):
        super().__init__("turtle_controller")
        self.choices = choices
        package, word, self.list_field, self.name_field, self.answer_field = choices.types
        self.catch = import_module(f"{package}.srv").CatchTurtle
        self.pose, self.turtles, self.is_waiting = None, [], False
        group = ReentrantCallbackGroup() if choices.answers == "threads" else None
        self.publisher = self.create_publisher(Twist, f"{choices.turtle}/cmd_vel", 10)
        self.create_subscription(Pose, f"{choices.turtle}/pose", self.on_pose, 10, callback_group=group)
        turtle_array = getattr(import_module(f"{package}.msg"), word)
        self.create_subscription(turtle_array, "alive_turtles", self.on_list, 10, callback_group=group)
        self.pen = self.create_client(SetPen, f"{choices.turtle}/set_pen") if choices.pen else None
        self.client = (
            None if choices.new_client else self.create_client(self.catch, choices.service, callback_group=group)
        )
        self.group = group
        if choices.answers != "spin":
            self.create_timer(1 / choices.hz, self.step, callback_group=group)

    def on_pose(self, pose):
        self.pose = pose

    def on_list(self, message):
        if self.choices.hasty:
            self.pose.x  # noqa: B018 - it dies if the list comes first, as many solutions do
        self.turtles = getattr(message, self.list_field)

    def step(self):
        if self.pose is None or not self.turtles:
            return
        turtle = self.choose()
        distance = self.distance(turtle)
        turn = math.remainder(math.atan2(turtle.y - self.pose.y, turtle.x - self.pose.x) - self.pose.theta, math.tau)
        gain = min(6.0, 0.8 * self.choices.hz)
        twist = Twist()
        if distance >= self.choices.stop:
            twist.linear.x = distance * min(2.0, 0.8 * self.choices.hz) * max(math.cos(turn), 0.0)
            twist.angular.z = gain * turn
        self.publisher.publish(twist)
        if distance < self.choices.stop and not self.is_waiting:
            self.is_waiting = True
            self.send_request(getattr(turtle, self.name_field))

    def distance(self, turtle):
        return math.hypot(turtle.x - self.pose.x, turtle.y - self.pose.y)

    def choose(self):
        if self.choices.target == "nearest":
            return min(self.turtles, key=self.distance)
        return self.turtles[0]

    def send_request(self, name):
        while self.pen is not None and not self.pen.wait_for_service(1.0):  # a colour for each catch
            self.get_logger().info("waiting for the pen")
        if self.pen is not None:
            self.pen.call_async(SetPen.Request(r=255, width=3))
        client = self.client or self.create_client(self.catch, self.choices.service)
        while not client.wait_for_service(1.0):
            self.get_logger().info("waiting for the service")
        request = self.catch.Request()
        setattr(request, self.name_field, name)
        if self.choices.answers == "threads":
            self.on_answer(name, client.call(request))
            return
        future = client.call_async(request)
        if self.choices.answers == "spin":
            rclpy.spin_until_future_complete(self, future)
            self.on_answer(name, future.result())
        else:
            future.add_done_callback(lambda done: self.on_answer(name, done.result()))

    def on_answer(self, name, response):
        caught = getattr(response, self.answer_field)
        self.turtles = [one for one in self.turtles if not (caught and getattr(one, self.name_field) == name)]
        self.log(f"{'caught' if caught else 'refused'} {name}")
        self.is_waiting = False

    def log(self, line):
        print(line, flush=True)  # noqa: T201


def main():
    parser = argparse.ArgumentParser()
    course = ["my_robot_interfaces", "TurtleArray", "turtles", "name", "success"]
    parser.add_argument("--types", nargs=5, default=course)
    parser.add_argument("--target", choices=("nearest", "first"), default="nearest")
    parser.add_argument("--answers", choices=("callback", "spin", "threads"), default="callback")
    parser.add_argument("--stop", type=float, default=0.5)
    parser.add_argument("--hz", type=float, default=10.0)
    parser.add_argument("--turtle", default="turtle1")
    parser.add_argument("--service", default="catch_turtle")
    for flag in ("--new-client", "--hasty", "--pen"):
        parser.add_argument(flag, action="store_true")
    rclpy.init()
    node = Controller(parser.parse_args(rclpy.utilities.remove_ros_args()[1:]))
    try:
        if node.choices.answers == "threads":
            executor = MultiThreadedExecutor()
            executor.add_node(node)
            executor.spin()
        elif node.choices.answers == "spin":
            while True:
                rclpy.spin_once(node, timeout_sec=1 / node.choices.hz)
                node.step()
        else:
            rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass


if __name__ == "__main__":
    sys.exit(main())
