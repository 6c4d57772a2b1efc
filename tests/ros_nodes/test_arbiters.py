"""`conformance` and `grade` on a service that is a real ROS 2 node."""

import pytest

pytestmark = pytest.mark.rclpy


def test_conformance_passes_a_node_that_follows_the_rules(bus_with):
    bus = bus_with("my_robot_interfaces")
    bus.node("referee", "--judges", "0.3")
    code, printed = bus.command("conformance", "ros:/catch_turtle", "--only", "reach").finish()
    assert code == 0, printed


def test_conformance_and_grade_find_a_node_with_another_reach(bus_with, tmp_path):
    """The cases between the two reaches fail, and give no points."""
    bus = bus_with("my_robot_interfaces")
    bus.node("referee", "--judges", "0.5")
    code, printed = bus.command("conformance", "ros:/catch_turtle", "--only", "reach").finish()
    assert code == 1, printed
    assert "R5.3" in printed
    (tmp_path / "spec.toml").write_text('[[test]]\nname = "reach"\ncases = ["reach"]\npoints = 4\n')
    code, printed = bus.command("grade", "ros:/catch_turtle", "--spec", "spec.toml").finish()
    assert "ros:/catch_turtle has 0 of 4 points" in printed
