"""The arena, and your controller in it.

ros2 launch catch_arena_interfaces arena.launch.py package:=my_package executable:=turtle_controller
"""

from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    ExecuteProcess,
    RegisterEventHandler,
    SetEnvironmentVariable,
)
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """The arena first; when its match has ended, so has everything."""
    arena = ExecuteProcess(
        cmd=[
            "catch-arena",
            "ros",
            "serve",
            "--interfaces",
            LaunchConfiguration("interfaces"),
            "--turtlesim",
            LaunchConfiguration("turtlesim"),
            "--set",
            ["spawn_frequency_hz=", LaunchConfiguration("spawn_frequency")],
            "--set",
            ["name_prefix=", LaunchConfiguration("name_prefix")],
            "--set",
            ["time_limit_s=", LaunchConfiguration("time_limit")],
        ],
        output="screen",
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument("package", description="Your package."),
            DeclareLaunchArgument("executable", default_value="turtle_controller", description="Your controller."),
            DeclareLaunchArgument("interfaces", default_value="my_robot_interfaces", description="Your interfaces."),
            DeclareLaunchArgument("turtlesim", default_value="turtlesim", description="turtlesim_msgs from Kilted on."),
            DeclareLaunchArgument("spawn_frequency", default_value="1.0", description="Targets a second."),
            DeclareLaunchArgument("name_prefix", default_value="target_turtle_", description="Of the targets' names."),
            DeclareLaunchArgument("time_limit", default_value="60", description="Of the match, in seconds."),
            SetEnvironmentVariable("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp"),
            arena,
            Node(package=LaunchConfiguration("package"), executable=LaunchConfiguration("executable"), output="screen"),
            RegisterEventHandler(OnProcessExit(target_action=arena, on_exit=[EmitEvent(event=Shutdown())])),
        ]
    )
