"""`catch-arena grade` gives points and hints by a spec, hides seeds, and reports a wrong spec in one line."""

import json
import re
from importlib.resources import files
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from tournament.agents import source, write_agent

from catch_arena.cli import terminal
from catch_arena.errors import ConfigError
from catch_arena.tournament.grading_spec import read_spec

BAD = Path(__file__).parent / "isolation" / "bad"
DOCS = Path(__file__).parents[2] / "docs"
SEED = "seed = 'c0ffee00c0ffee00c0ffee00c0ffee00'"
SPEC = f"""
title = "Exercise 1"
{SEED}
matches = 2
[[test]]
name = "alone"
scenario = "capstone"
settings = {{ time_limit_s = 10 }}
points = 2
min_mean_score = 2
[[test]]
name = "against one that holds"
scenario = "duel"
settings = {{ time_limit_s = 8 }}
opponents = ["idle"]
min_win_share = 0.5
max_mean_refused = 3
"""


@pytest.fixture
def grade(catch_arena):
    def call(agent, *words, spec=SPEC):
        Path("spec.toml").write_text(spec)
        return catch_arena("grade", str(agent), "--spec", "spec.toml", *words)

    return call


def test_a_good_agent_has_all_points(grade):
    result = grade("nearest", "--json", "out/grades.json", "--junit", "out/grades.xml")
    assert result.exit_code == 0, result.output
    assert result.stdout.endswith("Exercise 1: nearest has 3 of 3 points\n")
    grades = json.loads(Path("out/grades.json").read_text())
    assert (grades["agent"], grades["points"], grades["possible"]) == ("nearest", 3.0, 3.0)
    assert [test["test"] for test in grades["tests"]] == ["alone", "against one that holds"]
    assert grades["tests"][0]["mean_score"] >= 2
    assert grades["tests"][1]["win_share"] == 1.0
    suite = ET.parse("out/grades.xml").getroot()  # noqa: S314 - our own
    assert (suite.get("tests"), suite.get("failures")) == ("2", "0")
    assert not suite.findall(".//failure")


def test_seeds_stand_in_no_output(grade):
    result = grade(BAD / "crashes.py", "--json", "grades.json", "--junit", "grades.xml", "--seeds", "seeds.json")
    assert result.exit_code == 1, result.output
    seeds = json.loads(Path("seeds.json").read_text())
    assert seeds["seed"] == "c0ffee00" * 4
    matches = [match for test in seeds["tests"] for match in test["matches"]]
    assert [match["party"] for match in matches] == [0, 0, 0, 1]
    hidden = {match["seed"] for match in matches} | {seed for match in matches for seed in match["agent_seeds"]}
    assert len(hidden) == 10
    for text in (result.output, Path("grades.json").read_text(), Path("grades.xml").read_text()):
        assert not [seed for seed in (*hidden, "c0ffee") if str(seed) in text]


def test_the_seeds_of_a_match_of_teams_name_the_students_team(grade):
    teams = SPEC.replace('"duel"', '"standard"').replace(
        "time_limit_s = 8", "time_limit_s = 1, teams = [[0, 1], [2, 3]]"
    )
    grade("idle", "--seeds", "seeds.json", spec=teams)
    matches = json.loads(Path("seeds.json").read_text())["tests"][1]["matches"]
    assert [match["party"] for match in matches] == [0, 1]


def test_an_agent_is_told_its_own_seeds_and_of_the_matches_only_what_it_sees(grade):
    write_agent(Path("prints.py"), "raise ValueError", "print(seed)")
    grade("prints.py", "--json", "grades.json", "--seeds", "seeds.json")
    logged_seeds = [test["log"].split()[0] for test in json.loads(Path("grades.json").read_text())["tests"]]
    tests = json.loads(Path("seeds.json").read_text())["tests"]
    assert logged_seeds == [str(test["matches"][0]["agent_seeds"][0]) for test in tests]
    assert len({match["seed"] for test in tests for match in test["matches"]}) == 4


def test_a_bad_agent_has_none_and_is_told_why_and_what_to_read(grade):
    result = grade(BAD / "crashes.py", "--junit", "grades.xml")
    assert result.exit_code == 1
    assert "failed  0/2  alone: 2 matches" in result.output
    assert "FORFEIT_CRASH in step 5: act raised ZeroDivisionError" in result.output
    assert result.output.count("hint: R7.2: ") == 1  # alone it sees no target in step 5
    suite = ET.parse("grades.xml").getroot()  # noqa: S314 - our own
    assert suite.get("failures") == "2"
    assert suite.find("testcase/failure").get("message").startswith("FORFEIT_CRASH in step 5")
    assert "ZeroDivisionError" in suite.find("testcase/system-out").text
    assert {one.get("name"): one.get("value") for one in suite.iter("property")} == {"points": "0", "possible": "3"}


def test_one_that_forfeits_too_often_in_a_row_does_not_play_the_rest_of_a_test(grade):
    spec = SPEC.replace("matches = 2", "matches = 12")
    result = grade(BAD / "crashes.py", "--json", "grades.json", spec=spec)
    assert result.stdout.count("FORFEIT_OUT: it had forfeited 10 matches in a row; 2 more were not played") == 2
    assert [test["matches"] for test in json.loads(Path("grades.json").read_text())["tests"]] == [10, 10]


def test_two_time_outs_end_a_test_and_how_far_it_is_is_shown(grade, monkeypatch):
    monkeypatch.setattr(terminal, "_LINE_EVERY_S", 0.0)
    write_agent(Path("hangs.py"), "while True: pass")
    limits = ["--limit", "step_ms=50", "--limit", "bank_s=0"]
    result = grade("hangs.py", *limits, "--json", "grades.json", spec=SPEC.replace("matches = 2", "matches = 5"))
    assert result.exit_code == 1
    assert result.stdout.count("FORFEIT_OUT: it took too long in 2 matches; 3 more were not played") == 2
    assert [test["matches"] for test in json.loads(Path("grades.json").read_text())["tests"]] == [2, 2]
    for name in ("alone", "against one that holds"):
        assert re.findall(rf"^{name}: (\d) of 5, \d+ s, about \d+ s left$", result.stderr, re.MULTILINE) == ["1", "2"]


MAY_IMPORT = "hint: `catch-arena docs agents`, What it may import: "
LIMITS = "hint: `catch-arena docs isolation`, Limits: "
NAPS = "import time; time.sleep(60)"
CIRCLES = """
class Agent:
    control = 'full'
    def reset(self, seed): pass
    def act(self, view): return {'cmd_vel': (0.1, 1.0), 'catch': view.mask[1]}
"""
"""Drives a circle, and asks for whatever is nearest, out of reach."""


@pytest.mark.parametrize(
    ("source", "limits", "words"),
    [
        ("import rclpy\n", [], ["it imports rclpy, which is not installed here", MAY_IMPORT]),
        (source(reset="import rclpy"), [], ["reset raised ModuleNotFoundError: No module named 'rclpy'", MAY_IMPORT]),
        (
            source(NAPS),
            ["step_ms=30", "bank_s=0.2"],
            ["took longer than step_ms (30 ms) and what was left of bank_s (0.2 s)", LIMITS + "an action has step_ms"],
        ),
        (
            source(reset=NAPS),
            ["init_s=3"],
            ["before the first step: ", "init_s (3 s)", LIMITS + "its import and reset together have init_s"],
        ),
        (source("return 1 / 0"), [], ["hint: `catch-arena docs agents`: an exception in act ends its match"]),
        ("class Agent\n", [], ["FORFEIT_INIT before the first step: ", "importing it raised SyntaxError"]),
        (source(), [], ["hint: R4.1, R4.4: it never asked"]),
        (CIRCLES, [], ["mean_refused must be at most 3, got ", "hint: R5.3: a catch needs less than reach_m"]),
    ],
    ids=["import", "late import", "slow", "late start", "crash", "no Python", "never asks", "out of reach"],
)
def test_a_failure_is_told_with_the_hint_that_fits(grade, source, limits, words):
    Path("mine.py").write_text(source)
    once = SPEC.replace("matches = 2", "matches = 1")
    result = grade("mine.py", *(word for limit in limits for word in ("--limit", limit)), spec=once)
    assert result.exit_code == 1
    for word in words:
        assert word in result.output, result.output


def test_a_trusted_agent_that_cannot_begin_fails_all_tests(grade):
    Path("mine.py").write_text("class Agent\n")
    result = grade("mine.py", "--trusted")
    assert result.exit_code == 1
    assert result.stdout.count("importing it raised SyntaxError") == 2


@pytest.mark.parametrize(
    ("settings", "empty"),
    [
        ("{ initial_targets = 0 }", {"targets"}),
        ("{ view_radius_m = 0.001 }", {"targets", "rivals"}),
        ("{ initial_targets = 8 }", set()),
        ("{ initial_targets = 8, hunters = 1 }", set()),  # rivals that the arena does not have are no cause
    ],
)
def test_a_crash_is_explained_by_the_lists_of_the_view_that_were_empty(grade, settings, empty):
    write_agent(Path("fails.py"), "return [][0]")
    spec = f"""
{SEED}
matches = 1
[[test]]
name = "fails"
scenario = "duel"
settings = {settings}
opponents = ["idle"]
"""
    result = grade("fails.py", spec=spec)
    assert set(re.findall(r"hint: R7\.2: view\.(\w+) was empty", result.output)) == empty
    assert ("check-agent shows" in result.output) == (not empty)


def test_it_is_prey_in_one_match_and_what_catches_it_counts(grade):
    spec = """
seed = 1
matches = 4
[[test]]
name = "flees"
scenario = "tag"
settings = { time_limit_s = 20, reach_m = 2.0 }
opponents = ["intercept"]
max_mean_caught = 0
"""
    result = grade("idle", "--json", "grades.json", spec=spec)
    (test,) = json.loads(Path("grades.json").read_text())["tests"]
    assert test["mean_caught"] >= 1
    assert f"mean_caught must be at most 0, got {test['mean_caught']:g}" in result.output


def test_an_opponents_file_or_folder_stands_beside_the_spec(grade):
    Path("course").mkdir()
    write_agent(Path("course/rival.py"))
    Path("course/folder").mkdir()
    write_agent(Path("course/folder/agent.py"))
    for opponent in ("rival.py", "folder", "./folder"):
        Path("course/spec.toml").write_text(SPEC.replace('"idle"', f'"{opponent}"'))
        result = grade("nearest", "--spec", "course/spec.toml")
        assert result.exit_code == 0, result.output


def read_spec_text(text):
    Path("read.toml").write_text(text)
    return read_spec(Path("read.toml"))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[[test]]", "[[test"), "is no TOML"),
        ((SPEC[SPEC.index("[[test]]") :].replace('"', "'"), ""), r"at least one \[\[test\]\] must be given"),
        (("title =", "titel ="), "unknown field spec.titel: did you mean title"),
        (("points = 2", "point = 2"), r"unknown field test\[1\]\.point: did you mean points"),
        (
            ("min_win_share = 0.5", "min_win_share = 50"),
            r"test\[2\]\.min_win_share must be a number <= 1.0, got 50",
        ),
        (("matches = 2", "matches = 0"), r"matches must be a whole number >= 1, got 0"),
        (("seed = 'c0ffee00c", "seed = 'c"), "seed must be 32 hexadecimal digits, or a whole number .* got 'c"),
        ((SEED, "seed = -1"), "seed must be a whole number .* got -1"),
        ((SEED, f"{SEED}\nseed_file = 'none.txt'"), "seed and seed_file must not both be given"),
        ((SEED, "seed_file = 'none.txt'"), "seed_file must be a file: .*none.txt"),
        ((SEED, "seed_file = 'read.toml'"), "seed_file must hold 32 .* or a number, and read.toml does not"),
        (("'duel'", "'dual'"), r"test\[2\]: unknown scenario 'dual': did you mean duel"),
        (("time_limit_s = 10", "time_limit = 10"), r"test\[1\]: unknown setting 'time_limit': did you mean"),
        (
            ("opponents = ['idle']", ""),
            r"test\[2\] needs opponents: 1 seat is empty; name agents, as in opponents = \[\"nearest\"\]",
        ),
        (("opponents = ['idle']", "opponents = 'idle'"), r"test\[2\]\.opponents must be a list, got 'idle'"),
        (("name = 'alone'", ""), r"test\[1\]\.name must be given"),
        (("points = 2", "max_mean_caught = 2"), r"max_mean_caught must be of a scenario with prey, got 'capstone'"),
    ],
)
def test_a_spec_that_cannot_be_is_one_line(tmp_path, monkeypatch, change, message):
    monkeypatch.chdir(tmp_path)
    text = SPEC.replace('"', "'")
    assert change[0] in text
    with pytest.raises(ConfigError, match=message) as raised:
        read_spec_text(text.replace(*change))
    assert str(raised.value).startswith("read.toml: ")
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("encoding", "why"),
    [
        ("utf-16", "must be text in UTF-8, but byte 1 is not: save the file as UTF-8"),
        ("utf-16-le", "must be text in UTF-8, but byte 19 is not: save the file as UTF-8"),
        ("latin-1", "must be text in UTF-8, but byte 10 is not: save the file as UTF-8"),
    ],
)
def test_text_in_another_encoding_is_named(tmp_path, encoding, why):
    (tmp_path / "spec.toml").write_text('title = "\u00e9"\n', encoding=encoding)
    (tmp_path / "of_seed.toml").write_text(SPEC.replace(SEED, "seed_file = 'seed.txt'"))
    (tmp_path / "seed.txt").write_text("12345678 \u00e9.", encoding=encoding)
    for spec, file in (("spec.toml", "spec.toml"), ("of_seed.toml", "seed.txt")):
        with pytest.raises(ConfigError) as raised:
            read_spec(tmp_path / spec)
        assert str(raised.value).endswith(f"{tmp_path / file}: {why}")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nearest", "--spec", "missing.toml"], "missing.toml: cannot be read: No such file or directory"),
        (["nearest", "--spec", "~unknown_user/spec.toml"], "~unknown_user/spec.toml: cannot be read: No such file"),
        (["nope", "--spec", "spec.toml"], "unknown agent 'nope'"),
        (["nearest", "--spec", "spec.toml", "--json", "file/grades.json"], "file: cannot be written"),
    ],
)
def test_words_that_cannot_be_are_one_line_and_exit_code_2(catch_arena, words, message):
    Path("spec.toml").write_text(SPEC)
    Path("file").touch()
    result = catch_arena("grade", *words)
    assert result.exit_code == 2
    assert message in result.stderr
    assert len(result.stderr.splitlines()) == 1


def test_an_opponent_that_cannot_play_is_the_specs_fault(grade, tmp_path):
    (tmp_path / "broken.py").write_text("raise ValueError('no')\n")
    result = grade("nearest", spec=SPEC.replace('"idle"', '"broken.py"'))
    assert result.exit_code == 2
    assert "spec.toml: against one that holds: opponent broken.py cannot play: " in result.stderr


def test_an_opponent_of_an_unknown_user_is_one_line(grade):
    result = grade("nearest", spec=SPEC.replace('"idle"', '"~unknown_user"'))
    assert result.exit_code == 2
    assert result.stderr.startswith("error: unknown agent '~unknown_user': ")
    assert len(result.stderr.splitlines()) == 1


def test_what_hints_point_at_is_there():
    """Pages, and headings in them."""
    hints = (files("catch_arena.tournament") / "hints.toml").read_text()
    pointers = re.findall(r"`catch-arena docs (\w+)`(?:, ([^:]+):)?", hints)
    assert ("isolation", "Limits") in pointers
    for page, heading in pointers:
        assert f"# {heading}" in next(DOCS.rglob(f"{page}.md")).read_text()
