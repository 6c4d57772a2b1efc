"""`catch-arena conformance` prints, writes and exits as its page shows."""

import re
import shlex
from functools import partial
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from catch_arena.conformance.cases import ArenaCase, load_cases
from catch_arena.files import tomllib
from catch_arena.testing import run_conformance

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "howto" / "conformance.md").read_text(encoding="utf-8")
CASES_PAGE = (DOCS / "reference" / "conformance_cases.md").read_text(encoding="utf-8")


@pytest.fixture
def conformance(catch_arena, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    return partial(catch_arena, "conformance")


def blocks(language: str, page: str = PAGE) -> list[str]:
    return re.findall(rf"```{language}(?: file=\S+)?\n(.*?)```", page, re.DOTALL)


def test_a_right_arbiter_passes(conformance):
    result = conformance("catch_arena:arbitrate")
    assert result.exit_code == 0, result.output
    assert re.fullmatch(r"cases: \d+ passed, 0 failed, \d+ not played without an arena\n", result.output)


def test_the_pages_arbiter_gets_the_report_that_the_page_shows(conformance, tmp_path):
    """The command is the one that the page names."""
    (tmp_path / "my_arbiter.py").write_text(blocks("python")[0])
    result = conformance(*shlex.split(blocks("sh")[0])[2:])
    assert result.exit_code == 1
    assert result.output == blocks("text")[0]


def test_all_shows_every_failure_in_full(conformance, tmp_path):
    """Without it they are told by mistake, and the last line says how to see more."""
    (tmp_path / "my_arbiter.py").write_text(blocks("python")[0])
    words = ["my_arbiter.py:arbiter", "--verdicts-only", "--only", "claimants"]
    by_mistake, everything = conformance(*words), conformance(*words, "--all")
    assert by_mistake.exit_code == everything.exit_code == 1
    assert by_mistake.output.count("FAILED") < everything.output.count("FAILED") == 17
    assert by_mistake.output.count("\n") < everything.output.count("\n") / 3
    assert by_mistake.output.splitlines()[-1] == (
        "--all shows every failure in full, --only claimants.two plays one case."
    )
    assert everything.output.splitlines()[-1] == "cases: 0 passed, 17 failed"


def test_the_pages_python_runs():
    exec(blocks("python")[1], {})  # noqa: S102 - that is what is tested


def test_the_pages_case_is_the_suites():
    file = Path(__file__).parents[2] / "catch_arena" / "conformance" / "cases" / "claimants.toml"
    shown, cases = blocks("toml", CASES_PAGE)[0], file.read_text(encoding="utf-8")
    assert tomllib.loads(shown)["case"][0] in tomllib.loads(cases)["case"]


def test_the_page_names_every_group_and_every_value_that_is_read():
    groups = CASES_PAGE.partition("## Groups")[2].partition("##")[0]
    assert {case.group for case in load_cases()} <= set(re.findall(r"`(\w+)`", groups))
    values = CASES_PAGE.partition("| key of `read()`")[2]
    read = {name for case in load_cases() if isinstance(case, ArenaCase) for step in case.play for name in step.read}
    assert read <= set(re.findall(r"`(\w+)`", values))


def test_an_arena_can_be_named_alone(conformance, tmp_path):
    """Here one of the tests' own, in a file beside the words."""
    (tmp_path / "mine.py").write_text(
        "from conformance.arenas import AdjudicatorUnderTest as Arena\ndef oracle():\n    return Arena('oracle')\n"
    )
    result = conformance("--arena", "mine.py:oracle", "--only", "spawning", "--only", "reach.in-a-corner")
    assert result.exit_code == 0, result.output
    assert result.output == "cases: 25 passed, 0 failed\n"


def test_the_cases_can_be_listed_and_one_be_played(conformance):
    result = conformance("--list")
    assert result.exit_code == 0
    assert [line.partition(" ")[0] for line in result.output.splitlines()] == [case.id for case in load_cases()]
    assert conformance("--list", "--only", "ties").output.count("\n") == 20
    assert "cases: 1 passed, 0 failed" in conformance("catch_arena:arbitrate", "--only", "claimants.two").output


def test_the_junit_file_has_a_test_case_for_each_case(conformance, tmp_path):
    """With the counts that build servers add up, and characters that XML can hold."""
    words = "\\x00\\ud800 <&\\x1b[31m"
    (tmp_path / "mine.py").write_text(f"def arbiter(**case):\n    raise ValueError('{words}')\n")
    result = conformance("mine.py:arbiter", "--junit", "out/report.xml")
    assert result.exit_code == 1
    root = ET.fromstring((tmp_path / "out" / "report.xml").read_bytes())  # noqa: S314 - our own file
    (suite,) = root
    cases = load_cases()
    assert (root.tag, suite.tag) == ("testsuites", "testsuite")
    assert [(test.get("classname"), test.get("name")) for test in suite] == [
        (f"conformance.{case.group}", case.id) for case in cases
    ]
    failed, skipped = suite.findall("testcase/failure"), suite.findall("testcase/skipped")
    assert len(failed) + len(skipped) == len(cases)
    for element in (root, suite):
        counts = [element.get(name) for name in ("tests", "failures", "skipped", "errors")]
        assert counts == [str(len(cases)), str(len(failed)), str(len(skipped)), "0"]
    assert all("Why it matters" in (failure.text or "") for failure in failed)
    assert all("<&" in failure.get("message", "") for failure in failed)


def test_a_report_without_failures_is_whole_xml():
    report = run_conformance(lambda **_: [], only=["basics.no-requests"])
    root = ET.fromstring(report.junit().encode())  # noqa: S314
    assert [test.get("name") for test in root.iter("testcase")] == ["basics.no-requests"]
    assert not list(root.iter("failure"))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "an arbiter or an arena must be given"),
        (["arbitrate"], "arbitrate: must be module:function or path.py:function"),
        (["catch_arena:arbitrat"], "has no function arbitrat; did you mean arbitrat"),
        (["catch_arena.training:Foo"], "has no function Foo"),
        (["notes.txt:f"], "notes.txt: no module notes is installed"),
        (["catch_arena:arbitrate", "--only", "zzz"], "no case begins with 'zzz': known: basics, capstone, "),
        (["no_such_module:f"], "no_such_module: no module no_such_module is installed"),
        (["missing.py:f"], "missing.py:f: no such file"),
        (["catch_arena.agents.nearest:Agent"], "is a class, but an arbiter is a function; check agents with"),
        (["broken.py:f"], "importing it raised ZeroDivisionError"),
        (["--arena", "broken_arena.py:make"], "broken_arena.py:make: creating the arena raised ZeroDivisionError"),
        (["catch_arena:arbitrate", "--only", "reech"], "no case begins with 'reech': did you mean reach"),
        (["catch_arena:arbitrate", "--junit", "taken/report.xml"], "taken: cannot be written"),
    ],
)
def test_wrong_words_are_one_line_and_exit_code_2(conformance, tmp_path, words, message):
    (tmp_path / "broken.py").write_text("1 / 0\n")
    (tmp_path / "broken_arena.py").write_text("def make():\n    1 / 0\n")
    for name in ("taken", "notes.txt"):
        (tmp_path / name).write_text("")
    result = conformance(*words)
    assert result.exit_code == 2
    assert message in result.stderr
    assert result.stderr.startswith("error: ")
    assert result.stderr.count("\n") == 1
    assert result.stdout == ""
