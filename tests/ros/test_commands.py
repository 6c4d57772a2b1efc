"""`catch-arena ros` answers wrong arguments and unusable machines with one line."""

import os
import subprocess
import sys

import command_line
import pytest
from ros.processes import own_domain

from catch_arena.cli import ros
from catch_arena.errors import ConfigError
from catch_arena.ros.nodes.rate import Rate


def run(*arguments):
    """Exit status, and all that is said."""
    result = command_line.run("ros", *arguments)
    return result.exit_code, result.output


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        (("serve", "--seat", "nearest"), "--seat must be SEAT=DRIVER, such as 0=ros or 1=patrol, got 'nearest'"),
        (("serve", "--seat", "0=ros", "--seat", "0=nearest"), "--seat 0 must be given once"),
        (("serve", "--seat", "0=ros:\x1b[31m"), "--seat 0: its name must have 1 to 100 printable characters"),
        (("serve", "--seat", "3=ros", "--set", "hunters=2"), "--seat must be from 0 to 1 in exercise, got 3"),
        (("serve", "-s", "duel", "--seat", "2=ros"), "--seat must be from 0 to 1 in duel, got 2"),
        (
            ("serve", "--interfaces", "my-robot"),
            "--interfaces must be letters, digits and underscores, such as my_robot_interfaces, got ",
        ),
        (("controller", "--turtle", "bad name!"), "--turtle must be letters, digits and underscores, such as turtle1"),
        (("spawner", "--ros-args", "-p", "spawn_frequency:=nan"), "spawn_frequency_hz must"),
        (
            ("spawner", "--ros-args", "-p", "turtle_name_prefix:=2nd"),
            "turtle_name_prefix must be letters, digits and underscores, such as target_turtle_, got '2nd'",
        ),
        (("spawner", "--ros-args", "-p", "spawn_frequency:=2.0", "--", "--reach", "-1"), "reach_m must be"),
        (
            ("serve", "--ros-args", "-p", "catch_closest_turtle_first:=true"),
            "there is no parameter 'catch_closest_turtle_first': known: spawn_frequency, turtle_name_prefix",
        ),
        (("serve", "--speed", "0"), "--speed must be above 0 and at most 100, got 0"),
        (
            ("serve", "--bus", "ws://127.0.0.1:1"),
            "no rosbridge server answers at ws://127.0.0.1:1",
        ),
        (
            ("serve", "--bus", "http://127.0.0.1:1"),
            "--bus must be rclpy, cyclonedds, rosbridge, or an address such as ws://127.0.0.1:9090, got 'http://",
        ),
        (("serve", "--set", "control_period_ms=100"), "--set control_period_ms=... must be left out: on a bus each"),
        (("serve", "--seat", "0=Ros"), "unknown agent 'Ros'"),
        (("serve", "--seat", "0=neerest"), "unknown agent 'neerest': did you mean nearest or intercept?"),
    ],
)
def test_what_cannot_be_is_one_line(arguments, error, monkeypatch, tmp_path):
    """Before anything begins."""
    monkeypatch.setenv("ROS_LOCALHOST_ONLY", "1")
    monkeypatch.setenv("ROS_DOMAIN_ID", "97")
    monkeypatch.chdir(tmp_path)
    status, output = run(*arguments)

    assert status == 2
    assert error in " ".join(output.split())
    assert "Traceback" not in output
    assert "bus: " not in output  # it is not joined for that


@pytest.mark.parametrize("domain", ["233", "-1", "x"])
def test_a_domain_that_does_not_exist_is_one_line(monkeypatch, domain):
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    status, output = run("controller")
    assert (status, output) == (2, f"error: ROS_DOMAIN_ID must be a whole number from 0 to 232, got {domain}\n")


def test_ctrl_c_is_the_documented_end_of_the_nodes_also_while_they_wait(monkeypatch):
    """The spawner waits for turtlesim, which never comes."""

    def interrupted(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(Rate, "sleep", interrupted)
    with own_domain() as domain:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        status, printed = run("spawner", "--bus", "cyclonedds")
        assert status == 0
        assert "waiting for turtlesim: /spawn and /kill\n" in printed
        assert run("controller", "--bus", "cyclonedds")[0] == 0


@pytest.mark.skipif(sys.platform != "linux" or os.geteuid() != 0, reason="only root may take a network away")
@pytest.mark.parametrize("variables", [{}, {"ROS_LOCALHOST_ONLY": "1"}])
def test_without_a_network_interface_it_is_one_line(variables):
    """In a network of its own, whose only interface is down, the loopback interface."""
    found = subprocess.run(
        ["unshare", "--net", sys.executable, "-m", "catch_arena", "ros", "serve"],
        check=False,
        capture_output=True,
        text=True,
        timeout=240,
        env=os.environ | variables,
    )
    assert found.returncode == 2
    (line,) = [line for line in found.stderr.splitlines() if line.startswith("error: ")]
    assert line.startswith(
        "error: DDS domain 0 cannot be joined (DDS_RETCODE_ERROR): is there a network interface, and is CYCLONEDDS_URI "
    )
    assert line.endswith(" ROS_LOCALHOST_ONLY=1 limits ROS to this machine")


@pytest.mark.parametrize(("agent", "closest", "driver"), [("nearest", "false", "first"), ("first", "true", "nearest")])
def test_catch_closest_turtle_first_chooses_the_agent(monkeypatch, agent, closest, driver):
    def refuse(specs, _):
        raise ConfigError(f"{specs} drive")

    monkeypatch.setattr(ros, "enter_agents", refuse)
    status, printed = run("controller", agent, "--ros-args", "-p", f"catch_closest_turtle_first:={closest}")
    assert (status, printed) == (2, f"error: ['{driver}'] drive\n")
