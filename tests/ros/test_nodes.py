"""Students' referees, each in a process, are tested and graded over a bus."""

import json
import re
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from xml.etree import ElementTree as ET

import command_line
import pytest
from ros.bridge import running_bridge
from ros.processes import own_domain, started
from ros.referee import Referee

from catch_arena.ros.middleware.opening import open_bus

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


def tried(mistake, *words):
    """Run a command next to a referee in a domain of its own: (exit code, stdout, stderr)."""
    with ExitStack() as stack:
        domain = stack.enter_context(own_domain())
        if mistake is not None:
            referee = stack.enter_context(started("referee.py", domain, 120, mistake))
            assert referee.stdout.readline() == "ready\n"
        command = stack.enter_context(started(None, *words, "--bus", "cyclonedds", ROS_DOMAIN_ID=str(domain)))
        stdout, stderr = command.communicate(timeout=110)
    assert "Traceback" not in stderr
    return command.returncode, stdout, stderr


def conformance(mistake, *only):
    return tried(mistake, "conformance", "ros:/catch_turtle", *(word for one in only for word in ("--only", one)))


JOBS = {
    "right": lambda _: conformance("right", "basics", "identity", "names.255", "names.256", "reach.3", "reach.299"),
    "yes": lambda _: conformance("says_yes", "names.unknown", "names.ones-own", "reach.no-square"),
    "own list": lambda _: conformance("its_own_list", "reach.3", "reach.299", "names.unknown", "names.caught-in"),
    "own list, yes": lambda _: conformance("its_own_list says_yes", "reach.300000-is-out", "names.unknown"),
    "silent": lambda _: conformance("silent", "basics", "reach"),
    "nobody": lambda _: conformance(None, "basics"),
    "graded until it is silent": lambda folder: tried(
        "falls_silent",
        *("grade", "ros:/catch_turtle", "--spec", folder / "spec.toml", "--junit", folder / "silent.xml"),
    ),
    "graded": lambda folder: tried(
        "floats",
        *("grade", "ros:/catch_turtle", "--spec", folder / "spec.toml"),
        *("--json", folder / "g.json", "--junit", folder / "g.xml"),
    ),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("nodes")
    (made / "spec.toml").write_text(SPEC)
    return made


@pytest.fixture(scope="module")
def outcomes(folder):
    """Results of all jobs, of which some run at the same time."""
    with ThreadPoolExecutor(4) as pool:
        running = {name: pool.submit(job, folder) for name, job in JOBS.items()}
        return {name: one.result() for name, one in running.items()}


def test_a_right_referee_passes_what_it_is_asked(outcomes):
    code, stdout, stderr = outcomes["right"]
    assert code == 0, stdout + stderr
    assert "cases: 15 passed, 0 failed" in stdout


def test_a_wrong_referee_is_told_its_mistake(outcomes):
    code, stdout, stderr = outcomes["yes"]
    assert code == 1, stderr
    assert 'looks like "every request is granted"' in stdout


def test_the_exercises_spawner_which_keeps_the_list_is_asked_for_its_own_targets(outcomes):
    right, wrong = outcomes["own list"], outcomes["own list, yes"]
    for _, _, stderr in (right, wrong):
        assert "the node publishes /alive_turtles itself" in stderr
    assert right[0] == 0, right
    assert "cases: 5 passed, 0 failed" in right[1]
    assert wrong[0] == 1, wrong
    assert "cases: 0 passed, 2 failed" in wrong[1]


def test_the_marks_say_which_clause_failed(outcomes, folder):
    code, stdout, stderr = outcomes["graded"]
    assert code == 1, stderr
    assert (
        "failed  0/4  within reach: 2 of 3 cases\n        R5.3: 1 case: reach.300000-that-floats-call-less\n" in stdout
    )
    assert (
        "hint: it looks like «reach is tested in floats». A target is within reach if distance_um < reach_um" in stdout
    )
    assert "passed  2/2  names: 3 of 3 cases" in stdout
    assert stdout.endswith("The referee: ros:/catch_turtle has 2 of 6 points\n")
    grade = json.loads((folder / "g.json").read_text())
    assert (grade["agent"], grade["points"], grade["possible"]) == ("ros:/catch_turtle", 2.0, 6.0)
    assert [test["failures"] for test in grade["tests"]] == [["R5.3: 1 case: reach.300000-that-floats-call-less"], []]
    suite = ET.parse(folder / "g.xml").getroot()  # noqa: S314 - our own
    assert [len(case.findall("failure")) for case in suite.findall("testcase")] == [1, 0]


def test_a_node_that_never_answers_is_one_line(outcomes):
    code, _, stderr = outcomes["silent"]
    error = "error: /catch_turtle does not answer on this bus: does the node run, in the same domain?"
    assert (code, stderr.splitlines()[1:]) == (2, [error])


def test_where_nobody_serves_it_one_line_says_so(outcomes):
    code, _, stderr = outcomes["nobody"]
    assert code == 2
    error = "error: no node serves /catch_turtle on this bus: does the node run, in the same domain?"
    assert stderr.splitlines()[1:] == [error]


@contextmanager
def behind(url):
    """A referee behind the bridge, which a student would run beside rosbridge_server."""
    ended, ready = threading.Event(), threading.Event()

    def run():
        bus = open_bus(url, log=lambda _: None)
        referee = Referee(bus)
        ready.set()
        while not ended.is_set():
            referee.tick()
        bus.close()

    student = threading.Thread(target=run)
    student.start()
    try:
        assert ready.wait(60)
        yield
    finally:
        ended.set()
        student.join(60)


@pytest.fixture
def spec(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("spec.toml").write_text(SPEC)
    return Path("spec.toml")


GRADE = ("grade", "--spec", "spec.toml")


def over_rosbridge(url, service, command, *words):
    return command_line.run(command, service, *words, "--bus", url)


def refused(error, *words):
    found = command_line.run(*words)
    assert (found.exit_code, found.stderr) == (2, f"error: {error}\n")


def test_over_rosbridge_a_right_node_passes_too():
    with running_bridge() as (_, url), behind(url):
        tried = over_rosbridge(url, "ros:/catch_turtle", "conformance", "--only", "basics")
    assert tried.exit_code == 0, tried.output
    assert re.search(r"^cases: 3 passed, 0 failed, \d+ cannot be asked of a service$", tried.stdout, re.MULTILINE)


@pytest.mark.usefixtures("spec")
@pytest.mark.parametrize("words", [("conformance", "--only", "names.unknown"), GRADE])
def test_over_rosbridge_too_one_line_says_that_nobody_serves_it(words):
    """There the server says so in its answer to the first request."""
    with running_bridge() as (_, url):
        tried = over_rosbridge(url, "ros:/x", *words)
    assert (tried.exit_code, tried.stdout) == (2, "")
    assert tried.stderr.splitlines()[1:] == [
        "warning: rosbridge: /x: Service /x does not exist",
        "error: /x does not answer on this bus: does the node run, in the same domain?",
    ]


@pytest.mark.parametrize("word", ["ros:", "ros:catch_turtle", "ros:/catch turtle", "ros:/", "ros:/1a"])
def test_what_no_service_is_called_is_one_line(word):
    refused(f"a service must be given as ros:/NAME, such as ros:/catch_turtle, got {word!r}", "conformance", word)


def test_an_arena_is_refused_with_a_service():
    why = "--arena must be left out with a service, which answers yes or no"
    refused(why, "conformance", "ros:/c", "--arena", "a:B")


@pytest.mark.parametrize("option", [["--bus", "rclpy"], ["--bus", "ws://x"], ["--interfaces", "x"]])
@pytest.mark.parametrize(
    "words", [["conformance", "catch_arena:arbitrate"], ["grade", "nearest", "--spec", "spec.toml"]]
)
def test_options_for_a_bus_are_refused_without_a_service(words, option, spec):
    spec.write_text('title = "t"\n[[test]]\nname = "a"\nscenario = "capstone"\nmin_mean_score = 1\n')
    refused(f"{option[0]} must come with the service of a node, such as ros:/catch_turtle", *words, *option)


@pytest.mark.parametrize(
    ("test", "why"),
    [
        ("settings = { hunters = 1 }", 'a: cases must be given for a node, as in cases = ["reach", "names"]'),
        ('cases = ["rech"]', "a: no case begins with 'rech': did you mean reach?"),
        ('cases = ["ties"]', "a: none of its cases can be asked of a service"),
        ('cases = ["reach"]\nmatches = 3', "test[1].matches must be left out beside cases"),
        ('cases = "reach"', "test[1].cases must be a list, got 'reach'"),
        ("cases = [1]", "test[1].cases[1] must be text, got 1"),
    ],
)
def test_a_spec_that_cannot_be_asked_of_a_node_is_one_line(spec, test, why):
    spec.write_text(f'[[test]]\nname = "a"\n{test}\n')
    with running_bridge() as (_, url):
        tried = over_rosbridge(url, "ros:/c", *GRADE)
    assert tried.exit_code == 2
    assert why in tried.stderr
    assert tried.stderr.splitlines()[-1].startswith("error: ")


REFEREE = f'exec "{sys.executable}" "{Path(__file__).with_name("referee.py")}" $ROS_DOMAIN_ID 120 "$(cat mistake)"'


def test_a_class_of_nodes_is_started_graded_and_ended_one_by_one(tmp_path):
    """Each in its folder, by the spec's launch command; a node that does not start costs only itself."""
    for name, mistake in (("ann", "floats"), ("ben", "ends"), ("cem", "right")):
        (tmp_path / "nodes" / name).mkdir(parents=True)
        (tmp_path / "nodes" / name / "mistake").write_text(mistake)
    (tmp_path / "nodes" / "dana.py").write_text("")
    (tmp_path / "spec.toml").write_text(f"launch = '''echo begins; grep -q ends mistake || {REFEREE}'''\n{SPEC}")
    words = ["grade", tmp_path / "nodes", "--ros", "--spec", tmp_path / "spec.toml", "--out", tmp_path / "out"]
    code, stdout, stderr = tried(None, *words)
    assert code == 0, stderr
    assert re.findall(r"^(\w+): (\d) of 6 points$", stdout, re.MULTILINE) == [
        ("ann", "2"),
        ("ben", "0"),
        ("cem", "6"),
        ("dana", "0"),
    ]
    marks = (tmp_path / "out" / "marks.csv").read_text()
    assert "no node serves /catch_turtle on this bus" in marks
    assert "its launch command ended with code 0" in marks
    assert "must be a folder" in marks
    page = (tmp_path / "out" / "pages" / "ann.html").read_text()
    assert "reach is tested in floats" in page
    assert re.search(r"<pre[^>]*>begins\nready</pre>", page)
    assert "<catch-replay" not in page
    listed = [path.read_bytes() for path in Path("/proc").glob("[0-9]*/cmdline") if path.exists()]
    assert not [one for one in listed if b"referee.py" in one and str(tmp_path).encode() in one]


@pytest.mark.parametrize(
    ("change", "words", "message"),
    [
        (("launch", "title"), [], "launch must be given for --ros"),
        (("", ""), ["--jobs", "2"], "--jobs must be left out with --ros"),
        (("reach.300000", "no-such-case"), [], "spec.toml: within reach: "),
    ],
)
def test_a_class_of_nodes_that_cannot_be_started_is_one_line(tmp_path, change, words, message):
    (tmp_path / "nodes" / "ann").mkdir(parents=True)
    text = SPEC.replace('title = "The referee"', 'launch = "true"')
    (tmp_path / "spec.toml").write_text(text.replace(*change))
    command = ["grade", tmp_path / "nodes", "--ros", "--spec", tmp_path / "spec.toml", "--out", tmp_path / "out"]
    result = command_line.run(*command, *words)
    assert (result.exit_code, message in result.stderr, len(result.stderr.splitlines())) == (2, True, 1), result.stderr
