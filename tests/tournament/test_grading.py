"""`catch-arena grade`: grades by a spec, for people, JSON readers and JUnit readers."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from typer.testing import CliRunner

from catch_arena.cli import main, progress
from catch_arena.errors import ConfigError
from catch_arena.tournament.grading import _HINTS, read_spec

BAD = Path(__file__).parent / "isolation" / "bad"
DOCS = Path(__file__).parents[2] / "docs" / "grading.md"
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
def grade(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def call(agent, *words, spec=SPEC):
        Path("spec.toml").write_text(spec)
        return CliRunner().invoke(main, ["grade", str(agent), "--spec", "spec.toml", *words])

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


def test_submissions_that_are_all_called_agent_are_told_apart_by_their_folders(grade):
    for student in ("ann", "bob"):
        Path(student).mkdir()
        Path(student, "agent.py").write_text("from catch_arena.agents.idle import Agent\n")
        result = grade(f"{student}/agent.py", "--json", f"{student}.json", "--junit", f"{student}.xml")
        assert result.stdout.splitlines()[-1].startswith(f"Exercise 1: {student}/agent has ")
        assert json.loads(Path(f"{student}.json").read_text())["agent"] == f"{student}/agent"
        assert f'classname="{student}/agent"' in Path(f"{student}.xml").read_text()


def test_trusted_and_isolated_give_the_same_marks(grade):
    grade("contested", "--json", "isolated.json")
    grade("contested", "--json", "trusted.json", "--trusted")
    assert Path("isolated.json").read_bytes() == Path("trusted.json").read_bytes()


def test_seeds_stand_in_no_output(grade):
    result = grade(BAD / "crashes.py", "--json", "grades.json", "--junit", "grades.xml", "--seeds", "seeds.json")
    assert result.exit_code == 1, result.output
    seeds = json.loads(Path("seeds.json").read_text())
    assert seeds["seed"] == "c0ffee00" * 4
    matches = [match for test in seeds["tests"] for match in test["matches"]]
    assert [match["seat"] for match in matches] == [0, 0, 0, 1]
    hidden = {match["seed"] for match in matches} | {seed for match in matches for seed in match["agent_seeds"]}
    assert len(hidden) == 10
    for text in (result.output, Path("grades.json").read_text(), Path("grades.xml").read_text()):
        assert not [seed for seed in (*hidden, "c0ffee") if str(seed) in text]


def test_an_agent_is_told_its_own_seeds_and_of_the_matches_only_what_it_sees(grade, tmp_path):
    (tmp_path / "tells.py").write_text(
        "class Agent:\n    def reset(self, seed): print(seed)\n    def act(self, view): raise ValueError\n"
    )
    grade("tells.py", "--json", "grades.json", "--seeds", "seeds.json")
    told = [test["log"].split()[0] for test in json.loads(Path("grades.json").read_text())["tests"]]
    tests = json.loads(Path("seeds.json").read_text())["tests"]
    assert told == [str(test["matches"][0]["agent_seeds"][0]) for test in tests]
    assert len({match["seed"] for test in tests for match in test["matches"]}) == 4


def test_without_a_seed_each_run_has_other_matches(grade):
    spec = SPEC.replace(SEED, "")
    seeds = set()
    for name in ("a.json", "b.json"):
        grade("idle", "--seeds", name, spec=spec)
        seeds.add(json.loads(Path(name).read_text())["seed"])
    assert len(seeds) == 2


def test_a_bad_agent_has_none_and_is_told_why_and_what_to_read(grade):
    result = grade(BAD / "crashes.py", "--junit", "grades.xml")
    assert result.exit_code == 1
    assert "failed  0/2  alone: 2 matches" in result.output
    assert "FORFEIT_CRASH in step 5: act raised ZeroDivisionError" in result.output
    assert "hint: R7.2: " in result.output
    suite = ET.parse("grades.xml").getroot()  # noqa: S314 - our own
    assert suite.get("failures") == "2"
    assert suite.find("testcase/failure").get("message").startswith("FORFEIT_CRASH in step 5")
    assert "ZeroDivisionError" in suite.find("testcase/system-out").text
    assert {one.get("name"): one.get("value") for one in suite.iter("property")} == {"points": "0", "possible": "3"}


def test_a_crash_has_the_hint_about_empty_views_only_if_the_view_was_empty(grade):
    spec = 'seed = 1\n[[test]]\nname = "meets"\nscenario = "duel"\nopponents = ["idle"]\nmatches = 1\n'
    result = grade(BAD / "crashes.py", spec=spec)
    assert "FORFEIT_CRASH in step 5" in result.output
    assert "hint: R7.2" not in result.output


def test_one_that_forfeits_too_often_in_a_row_does_not_play_the_rest_of_a_test(grade):
    spec = SPEC.replace("matches = 2", "matches = 5")
    result = grade(BAD / "crashes.py", "--max-forfeits", "3", "--json", "grades.json", spec=spec)
    assert result.stdout.count("FORFEIT_OUT: it had forfeited 3 matches in a row; 2 more were not played") == 2
    assert [test["matches"] for test in json.loads(Path("grades.json").read_text())["tests"]] == [3, 3]
    assert "FORFEIT_OUT" not in grade(BAD / "crashes.py", "--max-forfeits", "0", spec=spec).output


def test_two_time_outs_in_reset_end_a_test_too(grade, tmp_path):
    """They are FORFEIT_INIT, and took ten matches of ten seconds."""
    (tmp_path / "hangs.py").write_text(
        "class Agent:\n    def reset(self, seed):\n        while True: pass\n    def act(self, view): return 0\n"
    )
    result = grade("hangs.py", "--limit", "init_s=3", spec=SPEC.replace("matches = 2", "matches = 5"))
    assert result.exit_code == 1
    assert result.stdout.count("FORFEIT_OUT: it took too long in 2 matches; 3 more were not played") == 2


def test_two_time_outs_end_a_test_and_how_far_it_is_is_shown(grade, tmp_path, monkeypatch):
    """An agent that hangs used to take ten matches of five seconds in each test, without a line."""
    monkeypatch.setattr(progress, "_LINE_EVERY_S", 0.0)
    (tmp_path / "hangs.py").write_text(
        "class Agent:\n    def reset(self, seed): pass\n    def act(self, view):\n        while True: pass\n"
    )
    words = ["--limit", "step_ms=50", "--limit", "bank_s=0", "--json", "grades.json"]
    spec = SPEC.replace("matches = 2", "matches = 5")
    result = grade("hangs.py", *words, spec=spec)
    assert result.exit_code == 1
    assert result.stdout.count("FORFEIT_OUT: it took too long in 2 matches; 3 more were not played") == 2
    assert [test["matches"] for test in json.loads(Path("grades.json").read_text())["tests"]] == [2, 2]
    for name in ("alone", "against one that holds"):
        assert re.findall(rf"^{name}: (\d) of 5, \d+ s, some \d+ s left$", result.stderr, re.MULTILINE) == ["1", "2"]


@pytest.mark.parametrize(
    ("source", "words"),
    [
        (
            "import rclpy\nclass Agent: pass\n",
            ["it imports rclpy, which is not installed here", "hint: `catch-arena docs agents`, What it may import: "],
        ),
        (
            "class Agent:\n    def reset(self, seed): import rclpy\n    def act(self, view): return 0\n",
            [
                "reset raised ModuleNotFoundError: No module named 'rclpy'",
                "hint: `catch-arena docs agents`, What it may import: ",
            ],
        ),
        (
            "import time\nclass Agent:\n    def reset(self, seed): pass\n    def act(self, view): time.sleep(60)\n",
            [
                "act took longer than step_ms (30 ms) and what was left of bank_s (0.2 s)",
                "hint: `catch-arena docs isolation`, Limits: an action has step_ms",
            ],
        ),
    ],
)
def test_the_hint_fits_what_went_wrong(grade, tmp_path, source, words):
    (tmp_path / "mine.py").write_text(source)
    result = grade("mine.py", "--limit", "step_ms=30", "--limit", "bank_s=0.2")
    for word in words:
        assert word in result.output, result.output
    assert "class Agent" not in result.output
    assert "R1.3" not in result.output


def test_the_hint_of_a_late_start_names_its_limit(grade, tmp_path):
    (tmp_path / "mine.py").write_text(
        "import time\nclass Agent:\n    def reset(self, seed): time.sleep(60)\n    def act(self, view): return 0\n"
    )
    result = grade("mine.py", "--limit", "init_s=2")
    assert "FORFEIT_INIT before the first step: " in result.output
    assert "init_s (2 s)" in result.output
    assert "hint: `catch-arena docs isolation`, Limits: its import and reset together have init_s" in result.output


def test_what_hints_point_at_is_there():
    """Pages, and headings in them."""
    for page, heading in re.findall(r"docs/(\w+\.md)(?:#([\w-]+))?", " ".join(_HINTS.values())):
        text = (DOCS.parent / page).read_text()
        headings = [line.lstrip("# ").lower().replace(" ", "-") for line in text.splitlines() if line.startswith("#")]
        assert not heading or heading in headings


def test_one_that_cannot_begin_fails_every_test(grade, tmp_path):
    (tmp_path / "mine.py").write_text("class Agent\n")
    result = grade("mine.py")
    assert result.exit_code == 1
    assert result.stdout.count("FORFEIT_INIT before the first step: ") == 2


def test_what_is_missed_is_measured_and_hinted_at(grade, tmp_path):
    """It drives a circle under full control and asks for whatever is nearest, out of reach."""
    (tmp_path / "asks.py").write_text(
        "class Agent:\n    control = 'full'\n    def reset(self, seed): pass\n"
        "    def act(self, view): return {'cmd_vel': (0.1, 1.0), 'catch': view.mask[1]}\n"
    )
    result = grade("asks.py")
    assert result.exit_code == 1
    assert re.search(r"mean_refused must be at most 3, got \d\d", result.output)
    assert "hint: R5.3: a catch needs less than reach_m" in result.output


def test_one_that_never_asks_is_told_so(grade):
    assert "hint: R4.1, R4.4: it never asked" in grade("idle").output


def test_one_that_is_granted_all_and_is_too_slow_is_told_so(grade):
    result = grade("first", spec=SPEC.replace("min_mean_score = 2", "min_mean_score = 100"))
    assert "hint: R6.1: only granted catches count" in result.output


def test_an_opponents_file_stands_beside_the_spec(grade, tmp_path):
    (tmp_path / "course").mkdir()
    (tmp_path / "course" / "rival.py").write_text(
        "class Agent:\n    def reset(self, seed): pass\n    def act(self, view): return 0\n"
    )
    (tmp_path / "course" / "spec.toml").write_text(SPEC.replace('"idle"', '"rival.py"'))
    result = grade("nearest", "--spec", "course/spec.toml")
    assert result.exit_code == 0, result.output


def test_the_example_in_the_docs_runs(grade):
    (spec,) = re.findall(r"```toml\n(.*?)```", DOCS.read_text(), re.DOTALL)
    short = spec.replace("hunters = 1", "hunters = 1, time_limit_s = 5")
    short = short.replace('"duel"', '"duel"\nsettings = { time_limit_s = 5 }')
    assert short.count("time_limit_s") == 2
    Path("hidden_seed.txt").write_text("00112233445566778899aabbccddeeff\n")
    assert read_spec_text(spec).secret.digits == "00112233445566778899aabbccddeeff"
    assert re.search(r"nearest has \d+ of \d+ points", grade("nearest", spec=short).output)


def read_spec_text(text):
    Path("read.toml").write_text(text)
    return read_spec(Path("read.toml"))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[[test]]", "[[test"), "is no TOML"),
        (("title =", "titel ="), "unknown field spec.titel: did you mean title"),
        (("points = 2", "point = 2"), r"unknown field test\[1\]\.point: did you mean points"),
        (("points = 2", "points = -2"), r"test\[1\]\.points must be a number from 0 to 1e\+06, got -2"),
        (
            ("min_win_share = 0.5", "min_win_share = 50"),
            r"test\[2\]\.min_win_share must be a number from 0 to 1, got 50",
        ),
        (("min_mean_score = 2", "min_mean_score = 'two'"), r"test\[1\]\.min_mean_score must be a number .* got 'two'"),
        (("matches = 2", "matches = 0"), r"matches must be a whole number from 1 to 10000, got 0"),
        (("points = 2", "matches = 2.5"), r"test\[1\]\.matches must be a whole number from 1 to 10000, got 2.5"),
        (("seed = 'c0ffee00c", "seed = 'c"), "seed must be 32 hexadecimal digits, or a whole number .* got 'c"),
        ((SEED, "seed = -1"), "seed must be a whole number .* got -1"),
        ((SEED, "seed = [1, 2]"), r"seed must be a whole number .* got \[1, 2\]"),
        ((SEED, "seeds = [1, 2]"), "unknown field spec.seeds: did you mean seed"),
        ((SEED, f"{SEED}\nseed_file = 'none.txt'"), "seed and seed_file must not both be given"),
        ((SEED, "seed_file = 'none.txt'"), "seed_file must be a file: .*none.txt"),
        (
            (SEED, "seed_file = 'read.toml'"),
            "seed_file must hold 32 .* or a number, and read.toml does not",
        ),
        (("'duel'", "'dual'"), r"test\[2\]: unknown scenario 'dual': did you mean duel"),
        (("time_limit_s = 10", "time_limit = 10"), r"test\[1\]: unknown setting 'time_limit': did you mean"),
        (
            ("opponents = ['idle']", ""),
            r"test\[2\] needs opponents: 1 seat is empty; name agents, as in opponents = \[\"nearest\"\]",
        ),
        (
            ("settings = { time_limit_s = 8 }\nopponents = ['idle']", "settings = { hunters = 3 }"),
            r"test\[2\] needs opponents: 2 seats are empty",
        ),
        (("opponents = ['idle']", "opponents = 'idle'"), r"test\[2\]\.opponents must be a list, got 'idle'"),
        (("name = 'alone'", ""), r"test\[1\]\.name must be given"),
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


def test_files_that_an_editor_of_windows_wrote_are_read(tmp_path):
    """With a byte order mark and its ends of lines."""
    (tmp_path / "seed.txt").write_bytes(b"\xef\xbb\xbf00112233445566778899aabbccddeeff\r\n")
    spec = tmp_path / "spec.toml"
    spec.write_bytes(b"\xef\xbb\xbf" + SPEC.replace(SEED, "seed_file = 'seed.txt'").replace("\n", "\r\n").encode())
    read = read_spec(spec)
    assert (read.title, read.secret.digits) == ("Exercise 1", "00112233445566778899aabbccddeeff")


@pytest.mark.parametrize(
    ("encoding", "why"),
    [
        ("utf-32", "is text in UTF-32: save it as UTF-8"),
        ("utf-32-le", "is text in UTF-32: save it as UTF-8"),
        ("utf-32-be", "is text in UTF-32: save it as UTF-8"),
        ("utf-16", "is text in UTF-16: save it as UTF-8"),
        ("utf-16-le", "is text in UTF-16: save it as UTF-8"),
        ("utf-16-be", "is text in UTF-16: save it as UTF-8"),
        ("latin-1", "must be text in UTF-8, and byte 10 is none"),
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
        (["nope", "--spec", "spec.toml"], "unknown agent 'nope'"),
        (["nearest", "--spec", "spec.toml", "--json", "file/grades.json"], "file: cannot be written"),
    ],
)
def test_words_that_cannot_be_are_one_line_and_exit_code_2(tmp_path, monkeypatch, words, message):
    monkeypatch.chdir(tmp_path)
    Path("spec.toml").write_text(SPEC)
    Path("file").touch()
    result = CliRunner().invoke(main, ["grade", *words])
    assert result.exit_code == 2
    assert message in result.stderr
    assert len(result.stderr.splitlines()) == 1


def test_an_opponent_that_cannot_play_is_the_specs_fault(grade, tmp_path):
    (tmp_path / "broken.py").write_text("raise ValueError('no')\n")
    result = grade("nearest", spec=SPEC.replace('"idle"', '"broken.py"'))
    assert result.exit_code == 2
    assert "spec.toml: against one that holds: opponent broken.py must be able to play: " in result.stderr
