"""ros2/catch_arena_interfaces, which colcon builds: it has what goes over the bus."""

import ast
import re
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from rosbags.typesys import get_types_from_msg
from rosbags.typesys.store import Typestore
from typer.testing import CliRunner

from catch_arena.cli import main
from catch_arena.ros.interfaces import OWN_PACKAGE, RULING, STANDING, Interfaces
from catch_arena.ros.type_hashes import type_hash

PACKAGE = Path(__file__).parents[2] / "ros2" / OWN_PACKAGE
TYPES = Interfaces(OWN_PACKAGE)
MESSAGES = (TYPES.turtle, TYPES.turtle_array, RULING, STANDING)


@pytest.mark.parametrize("kind", MESSAGES, ids=lambda kind: kind.name)
def test_its_messages_are_those_that_we_send(kind):
    """By the hash that ROS would announce, which a reader of .msg files of somebody else's makes."""
    store = Typestore()
    for other in MESSAGES:
        text = (PACKAGE / f"{other.name.replace(f'{OWN_PACKAGE}/', '')}.msg").read_text(encoding="utf-8")
        store.register(get_types_from_msg(text, other.name))
    assert store.hash_rihs01(kind.name) == type_hash(kind)


def test_its_service_is_the_one_that_we_serve():
    """Request and response."""
    request, response = (PACKAGE / "srv" / "CatchTurtle.srv").read_text(encoding="utf-8").split("---\n")
    for text, kind in ((request, TYPES.catch_turtle.request), (response, TYPES.catch_turtle.response)):
        assert [line for line in text.splitlines() if not line.startswith("#")] == kind.definition.splitlines()


def test_cmake_builds_each_of_its_files_and_installs_the_launch_file():
    """And package.xml has the package's name."""
    cmake = (PACKAGE / "CMakeLists.txt").read_text(encoding="utf-8")
    files = {path.relative_to(PACKAGE).as_posix() for path in PACKAGE.glob("*/*") if path.suffix in {".msg", ".srv"}}
    assert set(re.findall(r'"((?:msg|srv)/\w+\.\w+)"', cmake)) == files
    assert "install(DIRECTORY launch " in cmake
    assert f"project({OWN_PACKAGE})" in cmake
    assert ET.parse(PACKAGE / "package.xml").getroot().findtext("name") == OWN_PACKAGE  # noqa: S314 - our own


def test_the_launch_file_names_options_that_there_are():
    """It is Python, and starts our command."""
    tree = ast.parse((PACKAGE / "launch" / "arena.launch.py").read_text(encoding="utf-8"))
    words = [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    options = {word for word in words if word.startswith("--")}
    assert options == {"--interfaces", "--turtlesim", "--set"}
    helped = CliRunner().invoke(main, ["ros", "serve", "--help"], env={"COLUMNS": "200"}).output
    assert all(option in helped for option in options)
