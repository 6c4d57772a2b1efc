"""Students' referees, each a process that knows the wire alone, tried over the loopback interface."""

import json
import os
import subprocess
import sys
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from ros.bridge import running_bridge
from typer.testing import CliRunner

from catch_arena.cli import main
from catch_arena.ros.node_cases import can_be_asked
from catch_arena.testing import select_cases

REFEREE = Path(__file__).parent / "referee.py"
SPEC = """
title = "The referee"
[[test]]
name = "within reach"
cases = ["reach.300000", "reach.299999-is-in"]
points = 4
[[test]]
name = "names"
cases = ["names.unknown", "names.caught-in-the-last-step", "names.ones-own"]
points = 2
"""


_numbers = count(os.getpid())


@pytest.fixture
def domain():
    """One of its own for each test, also where other processes run some."""
    return 20 + next(_numbers) % 200


@contextmanager
def referee(domain, mistake):
    process = subprocess.Popen([sys.executable, str(REFEREE), str(domain), "120", mistake])
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def run(domain, *words):
    """A command, in a process of its own: DDS's domains are configured once in each."""
    return subprocess.run(
        [sys.executable, "-m", "catch_arena", *map(str, words), "--bus", "cyclonedds"],
        env={**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_LOCALHOST_ONLY": "1", "COLUMNS": "100"},
        capture_output=True,
        text=True,
        timeout=110,
        check=False,
    )


def test_a_right_referee_passes_every_case_that_it_can_be_asked_also_the_second_time(domain):
    with referee(domain, "right"):
        whole = run(domain, "conformance", "ros:/catch_turtle")
        again = run(domain, "conformance", "ros:/catch_turtle", "--only", "names", "--only", "identity")
    asked = sum(map(can_be_asked, select_cases()))
    assert asked > 40
    assert f"cases: {asked} passed, 0 failed, " in whole.stdout, whole.stderr
    assert whole.returncode == 0
    assert again.returncode == 0, again.stdout


@pytest.mark.parametrize(
    ("mistake", "groups", "told"),
    [
        ("up_to_and_at", ["reach"], 'looks like "within reach is tested with <="'),
        ("floats", ["reach"], 'looks like "reach is tested in floats"'),
        ("no_reach", ["reach.t", "basics"], 'looks like "reach is not tested"'),
        ("capital_letters", ["names.c", "names.u"], 'looks like "capital letters do not matter in names"'),
        ("any_length", ["names.25"], 'looks like "a name may be as long as it likes"'),
        ("says_no", ["basics"], "refused where GRANTED is right"),
        ("says_yes", ["names.u", "names.ones-own"], "granted where UNKNOWN_TARGET is right"),
        ("catches_twice", ["names.u", "names.caught-in"], "granted where ALREADY_CAUGHT is right"),
    ],
)
def test_a_wrong_referee_is_told_its_mistake(domain, mistake, groups, told):
    with referee(domain, mistake):
        tried = run(domain, "conformance", "ros:/catch_turtle", *(word for one in groups for word in ("--only", one)))
    assert tried.returncode == 1, tried.stderr
    assert told in tried.stdout
    assert "Traceback" not in tried.stderr


@pytest.mark.parametrize(("mistake", "code"), [("its_own_list", 0), ("its_own_list says_yes", 1)])
def test_the_exercises_spawner_which_keeps_the_list_is_asked_for_its_own_targets(domain, mistake, code):
    words = ["--only", "reach.3", "--only", "reach.299999", "--only", "names.unknown", "--only", "names.caught-in"]
    with referee(domain, mistake):
        tried = run(domain, "conformance", "ros:/catch_turtle", *words)
    assert tried.returncode == code, tried.stdout + tried.stderr
    assert "the node publishes /alive_turtles itself" in tried.stderr
    assert ("0 failed" in tried.stdout) == (code == 0)


def test_the_marks_say_which_clause_failed(domain, tmp_path):
    (tmp_path / "spec.toml").write_text(SPEC)
    files = ["--spec", tmp_path / "spec.toml", "--json", tmp_path / "g.json", "--junit", tmp_path / "g.xml"]
    with referee(domain, "floats"):
        graded = run(domain, "grade", "ros:/catch_turtle", *files)
    assert graded.returncode == 1, graded.stderr
    assert "failed  0/4  within reach: 3 of 4 cases\n        R5.3: 1 case: reach.300000-that-floats-call-less\n" in (
        graded.stdout
    )
    assert "hint: it looks like «reach is tested in floats». Within reach is distance_um < reach_um" in graded.stdout
    assert "passed  2/2  names: 4 of 4 cases" in graded.stdout
    assert graded.stdout.endswith("The referee: ros:/catch_turtle has 2 of 6 points\n")
    told = json.loads((tmp_path / "g.json").read_text())
    assert (told["agent"], told["points"], told["possible"]) == ("ros:/catch_turtle", 2.0, 6.0)
    assert [test["failures"] for test in told["tests"]] == [["R5.3: 1 case: reach.300000-that-floats-call-less"], []]
    suite = ET.parse(tmp_path / "g.xml").getroot()  # noqa: S314 - our own
    assert [len(case.findall("failure")) for case in suite.findall("testcase")] == [1, 0]


def test_a_node_that_never_answers_is_given_up_in_one_line(domain):
    with referee(domain, "silent"):
        tried = run(domain, "conformance", "ros:/catch_turtle", "--only", "basics", "--only", "reach")
    assert tried.returncode == 2
    assert tried.stderr.endswith(
        "catch-arena: the node has not answered 3 requests one after the other: it is given up\n"
    )


def test_where_nobody_serves_it_one_line_says_so(domain):
    tried = run(domain, "conformance", "ros:/catch_turtle", "--only", "basics")
    assert tried.returncode == 2
    assert tried.stderr == (
        "catch-arena: nobody serves /catch_turtle on this bus: does the node run, in the same domain?\n"
    )


def test_over_rosbridge_a_right_node_passes_too():
    """A server behind the bridge, which a student would run beside rosbridge_server."""
    import threading
    from time import monotonic

    from catch_arena.messages import CatchTurtleResponse
    from catch_arena.ros.bus import open_bus
    from catch_arena.ros.interfaces import Interfaces

    types = Interfaces()
    state = {"pose": (0.0, 0.0), "turtles": {}, "end": monotonic() + 60}

    def serve(url):
        bus = open_bus("rosbridge", url=url, say=lambda _: None)
        bus.subscribe("/turtle1/pose", types.pose, lambda pose, _: state.update(pose=(pose.x, pose.y)))

        def hear(message, _):
            state["turtles"] = {one.name: (one.x, one.y) for one in message.turtles}

        def judge(request):
            x, y = state["pose"]
            place = state["turtles"].get(request.message.name)
            success = place is not None and (place[0] - x) ** 2 + (place[1] - y) ** 2 < 0.09
            request.answer(CatchTurtleResponse(success))

        bus.subscribe("/alive_turtles", types.turtle_array, hear)
        bus.serve("/catch_turtle", types.catch_turtle, judge)
        while monotonic() < state["end"]:
            bus.spin(0.05)
        bus.close()

    with running_bridge() as (_, url):
        student = threading.Thread(target=serve, args=(url,))
        student.start()
        try:
            words = ["conformance", "ros:/catch_turtle", "--bus", "rosbridge", "--url", url, "--only", "basics"]
            tried = CliRunner().invoke(main, words)
        finally:
            state["end"] = 0.0
            student.join(10)
    assert tried.exit_code == 0, tried.output
    assert "cases: 3 passed, 0 failed" in tried.stdout


@pytest.mark.parametrize("word", ["ros:", "ros:catch_turtle", "ros:/catch turtle", "ros:/", "ros:/1a"])
def test_what_no_service_is_called_is_one_line(word):
    refused = CliRunner().invoke(main, ["conformance", word])
    assert (refused.exit_code, refused.stderr) == (
        2,
        f"catch-arena: a service must be given as ros:/NAME, as ros:/catch_turtle, got {word!r}\n",
    )


@pytest.mark.parametrize("option", [["--arena", "a:B"], ["--exact-lots"]])
def test_options_for_arbiters_are_refused_with_a_service(option):
    with running_bridge() as (_, url):
        refused = CliRunner().invoke(main, ["conformance", "ros:/c", *option, "--bus", "rosbridge", "--url", url])
    assert refused.exit_code == 2
    assert "--arena and --exact-lots must be left out with a service" in refused.stderr


@pytest.mark.parametrize(
    ("test", "why"),
    [
        ('name = "a"', 'a: cases must be given for a node, as in cases = ["reach", "names"]'),
        ('name = "a"\ncases = ["rech"]', "a: no case begins with 'rech': did you mean reach?"),
        ('name = "a"\ncases = ["ties"]', "a: none of its cases can be asked of a service"),
        ('name = "a"\ncases = ["reach"]\nmatches = 3', "test[1].matches must be left out beside cases"),
        ('name = "a"\ncases = "reach"', "test[1].cases must be a list, got 'reach'"),
        ('name = "a"\ncases = [1]', "test[1].cases must be text, got 1"),
    ],
)
def test_a_spec_that_cannot_be_asked_of_a_node_is_one_line(tmp_path, test, why):
    (tmp_path / "spec.toml").write_text(f"[[test]]\n{test}\n")
    with running_bridge() as (_, url):
        words = ["grade", "ros:/c", "--spec", str(tmp_path / "spec.toml"), "--bus", "rosbridge", "--url", url]
        refused = CliRunner().invoke(main, words)
    assert refused.exit_code == 2
    assert why in refused.stderr
    assert refused.stderr.splitlines()[-1].startswith("catch-arena: ")


def test_an_agent_is_not_asked_a_nodes_cases(tmp_path):
    (tmp_path / "spec.toml").write_text(SPEC)
    refused = CliRunner().invoke(main, ["grade", "nearest", "--spec", str(tmp_path / "spec.toml"), "--trusted"])
    assert refused.exit_code == 2
    assert refused.stderr == (
        f"catch-arena: {tmp_path / 'spec.toml'}: within reach: cases are asked of a node, as ros:/catch_turtle, not of "
        "agents\n"
    )
