"""The arena, and your controller in it.

ros2 launch catch_arena_interfaces arena.launch.py package:=my_package executable:=turtle_controller
ros2 launch catch_arena_interfaces arena.launch.py package:=my_package seats:="0=ros:anna 1=patrol" record:=anna.replay
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    ExecuteProcess,
    OpaqueFunction,
    RegisterEventHandler,
    SetEnvironmentVariable,
)
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

_OPTIONS = ("scenario", "seed", "speed", "interfaces", "turtlesim", "bus", "record")
"""Of `catch-arena ros serve`."""
_REAL_TIME = ("", "1", "1.0")
"""Speeds at which there is no /clock."""
_SETTINGS = {"spawn_frequency": "spawn_frequency_hz", "name_prefix": "name_prefix", "time_limit": "time_limit_s"}
"""What --set calls them."""


def generate_launch_description() -> LaunchDescription:
    """The arena first; when its match has ended, so has everything."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("package", description="Your package."),
            DeclareLaunchArgument("executable", default_value="turtle_controller", description="Your controller."),
            DeclareLaunchArgument(
                "seats", default_value="", description="Who drives, as in '0=ros:anna 1=patrol'; else your node alone."
            ),
            DeclareLaunchArgument("scenario", default_value="", description="The arena to play in; else exercise."),
            DeclareLaunchArgument("seed", default_value="", description="Of the match; else drawn."),
            DeclareLaunchArgument("speed", default_value="", description="Of the simulation; else 1, real time."),
            DeclareLaunchArgument(
                "record", default_value="", description="A file for the replay; else it is not kept."
            ),
            DeclareLaunchArgument(
                "force",
                default_value="false",
                choices=["true", "false"],
                description="Whether the replay replaces a file that is there.",
            ),
            DeclareLaunchArgument(
                "interfaces", default_value="", description="Your interfaces; else those that your node uses."
            ),
            DeclareLaunchArgument(
                "turtlesim", default_value="", description="turtlesim's package; else the one that is installed."
            ),
            DeclareLaunchArgument(
                "bus",
                default_value="",
                description="rclpy, cyclonedds, rosbridge or its address; else the first that works.",
            ),
            DeclareLaunchArgument("domain", default_value="", description="Of DDS; else ROS_DOMAIN_ID, or 0."),
            DeclareLaunchArgument("spawn_frequency", default_value="", description="Targets a second."),
            DeclareLaunchArgument("name_prefix", default_value="", description="Of the targets' names."),
            DeclareLaunchArgument("time_limit", default_value="", description="Of the match, in seconds."),
            OpaqueFunction(function=_begin),
        ]
    )


def _begin(context: LaunchContext) -> list:
    """What is begun, now that the arguments are known."""

    def given(name: str) -> str:
        return LaunchConfiguration(name).perform(context)

    command = ["catch-arena", "ros", "serve"]
    for seat in given("seats").split():
        command += ["--seat", seat]
    for option in _OPTIONS:
        if given(option):
            command += [f"--{option}", given(option)]
    if given("force") == "true":
        command.append("--force")
    for name, setting in _SETTINGS.items():
        if given(name):
            command += ["--set", f"{setting}={given(name)}"]
    actions = []
    if given("bus") == "cyclonedds":  # the node must have the same middleware
        actions.append(SetEnvironmentVariable("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp"))
    if given("domain"):
        actions.append(SetEnvironmentVariable("ROS_DOMAIN_ID", given("domain")))
    arena = ExecuteProcess(cmd=command, output="screen")
    return [
        *actions,
        arena,
        Node(
            package=given("package"),
            executable=given("executable"),
            output="screen",
            parameters=[{"use_sim_time": given("speed") not in _REAL_TIME}],  # its timers go by the arena's /clock
        ),
        RegisterEventHandler(OnProcessExit(target_action=arena, on_exit=[EmitEvent(event=Shutdown())])),
    ]
