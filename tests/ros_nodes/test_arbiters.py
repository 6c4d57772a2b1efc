"""`conformance` and `grade` on a service that is a real ROS 2 node."""

import re
from pathlib import Path

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


def test_a_class_of_nodes_is_graded_and_none_is_left(bus_with, tmp_path):
    """One node follows the rules, one has another reach, and one ends at once."""
    bus = bus_with("my_robot_interfaces")
    for name, words in {"ann": ["--judges", "0.3"], "ben": ["--judges", "0.5"], "cem": ["--unknown"]}.items():
        (tmp_path / "nodes" / name).mkdir(parents=True)
        begin = f"import runpy, sys\nsys.argv = {['node.py', *words]!r}\n"
        node = f"{begin}runpy.run_path({str(bus.path_of('referee'))!r}, run_name='__main__')\n"
        (tmp_path / "nodes" / name / "node.py").write_text(node)
    spec = f'launch = "{bus.python} node.py"\n[[test]]\nname = "reach"\ncases = ["reach"]\npoints = 4\n'
    (tmp_path / "spec.toml").write_text(spec)
    code, printed = bus.command("grade", "nodes", "--ros", "--spec", "spec.toml", "--out", "out").finish()
    assert code == 0, printed
    assert re.findall(r"^(\w+): (\d) of 4 points$", printed, re.MULTILINE) == [("ann", "4"), ("ben", "0"), ("cem", "0")]
    marks = (tmp_path / "out" / "marks.csv").read_text()
    assert "R5.3" in marks
    assert "its launch command ended with code 2" in marks
    left = [path for path in Path("/proc").glob("[0-9]*/cwd") if _leads_into(path, tmp_path / "nodes")]
    assert left == []


def _leads_into(link, folder):
    try:
        return link.readlink().is_relative_to(folder)
    except OSError:
        return False
