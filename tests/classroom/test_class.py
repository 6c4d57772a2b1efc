"""`catch-arena grade FOLDER` grades a class: marks and pages, one bad submission costs itself, and a run continues."""

import base64
import csv
import gzip
import html
import json
import os
import re
import shutil
import sys
from datetime import datetime
from pathlib import Path

import pytest
from command_line import run
from interrupts.commands import Command
from tournament.agents import source

import catch_arena
from catch_arena.classroom.grading import Graded, grade_class, worst_match
from catch_arena.classroom.moments import worst_moment
from catch_arena.classroom.submissions import find_submissions
from catch_arena.errors import ConfigError, MatchFailedError
from catch_arena.replay import Replay
from catch_arena.scenarios import scenario
from catch_arena.tournament.execution import block_queue
from catch_arena.tournament.execution.executors import Executor
from catch_arena.tournament.grading import GradedMatch
from catch_arena.tournament.match import Forfeit, MatchResult
from catch_arena.tournament.match_loop import play_entrants
from catch_arena.tournament.players import enter
from catch_arena.tournament.store import only_one_plays_in

SPEC = """
title = "Exercise 1"
seed = "c0ffee00c0ffee00c0ffee00c0ffee00"
matches = 2
[[test]]
name = "alone"
scenario = "capstone"
settings = { time_limit_s = 5 }
points = 2
min_mean_score = 1
[[test]]
name = "against one that holds"
scenario = "duel"
settings = { time_limit_s = 8 }
opponents = ["idle"]
min_win_share = 0.5
"""
SAMPLE = Path(catch_arena.__file__).parent / "classroom" / "sample"
GOOD = (SAMPLE / "ann.py").read_text()
CLASS = {
    "ann/agent.py": GOOD,
    "ben.py": GOOD.replace("\n", "\r\n"),
    "cem_1234_file/hunter.py": GOOD.replace("choice", "picked"),
    "crash.py": source("print('about to fail'); return view.targets[9].rank"),
    "hang.py": source("while True: pass"),
    "late import.py": "import missing_library\n",
    "note.ipynb": '{"cells": []}',
    "two files/a.py": GOOD,
    "two files/b.py": GOOD,
    "README.md": "for the teacher",
}
NAMES = ["ann", "ben", "cem_1234_file", "crash", "hang", "late import", "note", "two files"]
LIMITS = ["--limit", "bank_s=2"]


def write_class(folder, files=CLASS):
    for name, text in files.items():
        path = folder / "class" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text.encode())
        os.utime(path, (1e9, 1e9))
    (folder / "spec.toml").write_text(SPEC)


def call(*words):
    return run("grade", *words)


def marks_in(folder):
    return {row["student"]: row for row in csv.DictReader((folder / "marks.csv").read_text().splitlines())}


def facts_in(page):
    """Return the facts of the replay in a page."""
    (bundle,) = re.findall(r'<catch-replay id="player" bundle="([^"]+)"', page)
    return json.loads(gzip.decompress(base64.b64decode(bundle)).partition(b"\n")[0])


@pytest.fixture(scope="module")
def graded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("graded")
    write_class(folder)
    words = ["--spec", folder / "spec.toml", "--out", folder / "out", "--jobs", "2", *LIMITS]
    return folder, call(folder / "class", *words, "--deadline", "2001-09-09T00:00")


def test_each_student_has_a_line_and_a_page_and_the_class_is_done(graded):
    folder, result = graded
    assert result.exit_code == 0, result.output
    marks = marks_in(folder / "out")
    assert list(marks) == NAMES
    assert {name: row["points"] for name, row in marks.items() if row["points"] != "0"} == dict.fromkeys(NAMES[:3], "3")
    assert {row["possible"] for row in marks.values()} == {"3"}
    assert sorted(path.stem for path in (folder / "out" / "pages").iterdir()) == NAMES
    excel = (folder / "out" / "marks_excel.csv").read_bytes()
    assert excel.startswith(b"\xff\xfe")  # without it, Excel puts all in one column where commas are in numbers
    assert list(csv.DictReader(excel.decode("utf-16").splitlines(), delimiter="\t")) == list(marks.values())
    assert "README.md is no submission" in result.stderr


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("crash", "FORFEIT_CRASH in step 1: act raised IndexError"),
        ("hang", "FORFEIT_TIMEOUT in step 1: "),
        ("late import", "it imports missing_library, which is not installed here"),
        ("note", "is a notebook"),
        ("two files", "is a folder without agent.py"),
    ],
)
def test_a_bad_submission_has_its_reason_without_the_teachers_folders(graded, name, reason):
    folder, _ = graded
    row, page = marks_in(folder / "out")[name], (folder / "out" / "pages" / f"{name}.html").read_text()
    assert reason in row["reason"]
    assert reason.partition(":")[0] in page
    assert str(folder) not in row["reason"] + page


def test_marks_are_those_of_grading_one_by_one(graded, tmp_path):
    folder, _ = graded
    marks = marks_in(folder / "out")
    for name, agent in (("ann", "ann"), ("ben", "ben.py"), ("crash", "crash.py"), ("hang", "hang.py")):
        words = ["--spec", folder / "spec.toml", "--json", tmp_path / f"{name}.json", *LIMITS]
        call(folder / "class" / agent, *words)
        alone = json.loads((tmp_path / f"{name}.json").read_text())
        assert (f"{alone['points']:g}", alone["digest"]) == (marks[name]["points"], marks[name]["digest"])
        kept = json.loads((folder / "out" / "json" / f"{name}.json").read_text())
        assert [test["failures"] for test in kept["grades"]] == [test["failures"] for test in alone["tests"]]


def test_a_page_has_hints_and_a_replay_but_no_seed_and_no_other_student(graded):
    folder, _ = graded
    page = (folder / "out" / "pages" / "crash.html").read_text()
    assert "0</b> of 3 points" in page
    assert "Hint: " in page
    assert re.search("<pre[^>]*>about to fail\n", page)
    assert "<code>catch-arena docs agents</code>" in page.partition("<catch-")[0]
    assert "`" not in page.partition("<script>")[0].partition("</style>")[2]
    assert "script-src &#39;sha256-" in page or "script-src 'sha256-" in page
    assert not re.findall(r"""(?:src|href)=["'](?!data:)""", page)
    facts = facts_in(page)
    assert facts["seed"] == "hidden"
    assert [one["text"] for one in facts["moments"]] == ["crash crashed here, step 1"]
    assert " data-stopped>" in page
    assert "c0ffee" not in page
    assert not [name for name in NAMES if name != "crash" and re.search(rf"\b{name}\b", page.partition("<catch-")[0])]


def test_a_page_without_failures_and_without_output_says_so(graded):
    folder, _ = graded
    page = (folder / "out" / "pages" / "ann.html").read_text()
    assert "<h2>A moment to improve</h2>" in page
    assert "<p>It printed nothing.</p>" in page
    assert " data-stopped>" not in page
    solo, duel = re.findall('<p class="quiet">(2 matches.*)</p>', page)
    assert ("wins" in solo, "wins 100 %" in duel) == (False, True)


def test_a_page_has_the_last_whole_lines_of_the_log_of_the_match_that_it_plays(tmp_path, monkeypatch):
    write_class(
        tmp_path, {"a.py": source("print(f'line {self.step}'); return 0 if self.step < 46 else view.targets[99]")}
    )
    monkeypatch.chdir(tmp_path)
    Path("spec.toml").write_text(SPEC.replace("points = 2", "points = 0.5"))
    assert call("class", "--spec", "spec.toml", "--jobs", "1").exit_code == 0
    page = Path("class_spec_grades/pages/a.html").read_text()
    assert [one["name"] for one in facts_in(page)["hunters"]] == ["a", "idle"]
    log = html.unescape(re.search("<pre[^>]*>(.*?)</pre>", page, re.DOTALL)[1]).splitlines()
    assert len(log) == 40
    assert all(re.match(r"line \d|Traceback| |IndexError", line) for line in log)


def test_the_first_forfeit_is_the_worst_match_though_a_later_one_has_fewer_catches():
    played = []
    for log, scores, forfeit in (
        ("no forfeit", (0, 9), None),
        ("first", (5, 2), Forfeit("FORFEIT_CRASH", 40, "")),
        ("second", (0, 9), Forfeit("FORFEIT_CRASH", 40, "")),
    ):
        both = ({}, {})
        result = MatchResult(scores, (1, 1), both, (0, 0), (0, 0), 40, "", (forfeit, None), (), (log, ""))
        played.append(GradedMatch(0, result, b""))
    assert worst_match(played, 2).result.logs[0] == "first"


def test_the_worst_moment_is_the_contest_that_was_lost_by_most(tmp_path):
    """Not the one in which the agent was farthest from the target: the winner was far away too."""
    agents = enter(["nearest", "nearest", "first", "patrol"])
    arena = scenario("standard", reach_m=1.0, time_limit_s=20)
    result = play_entrants(arena, 5, agents, None, record=tmp_path / "m.replay")
    replay = Replay.load(tmp_path / "m.replay")
    lost = [contest for contest in catch_arena.explain(replay, 0).contests if contest.claims[1].seat == 0]
    worst, farthest = (max(lost, key=key) for key in (lambda one: one.margin_um, lambda one: one.claims[1].distance_um))
    assert worst != farthest
    assert worst_moment(replay, 0, result).at_ms == worst.judged_ms


def test_late_and_similar_submissions_are_for_the_teacher_only(graded):
    folder, result = graded
    marks = marks_in(folder / "out")
    assert float(marks["ann"]["hours_late"]) > 0
    assert "ben: 100 % of the code has the same structure" in marks["ann"]["look_at"]
    assert "look at these two: ann and ben" in result.stdout
    assert "look at" not in (folder / "out" / "pages" / "ann.html").read_text()


def test_only_what_changed_is_graded_again(graded, tmp_path):
    folder, _ = graded
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    (tmp_path / "class" / "crash.py").write_text(GOOD)
    words = [tmp_path / "class", "--spec", tmp_path / "spec.toml", "--out", tmp_path / "out", "--jobs", "1", *LIMITS]
    again = call(*words)
    assert again.exit_code == 0, again.output
    assert "crash: 3 of 3 points\n" in again.stdout
    assert again.stdout.count("as graded before") == len(NAMES) - 1
    assert marks_in(tmp_path / "out")["crash"]["hours_late"] == ""
    (tmp_path / "class" / "hang.py").unlink()
    (tmp_path / "spec.toml").write_text(SPEC.replace("points = 2", "points = 4").replace("matches = 2", "matches = 1"))
    assert "as graded before" not in call(*words).stdout


def test_only_one_command_grades_into_a_folder(tmp_path):
    write_class(tmp_path, {"a.py": GOOD})
    (tmp_path / "out").mkdir()
    with only_one_plays_in(tmp_path / "out"):
        refused = call(tmp_path / "class", "--spec", tmp_path / "spec.toml", "--out", tmp_path / "out")
    assert refused.exit_code == 2
    assert "out: another command is playing in this folder" in refused.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_after_an_interrupt_what_was_graded_is_kept_and_no_process_is_left(tmp_path):
    write_class(tmp_path, {"a.py": GOOD, "b.py": source("while True: pass"), "c.py": GOOD})
    words = ["grade", "class", "--spec", "spec.toml", "--jobs", "2"]
    command = Command(tmp_path, words)
    assert command.process.stdout.readline() == "a: 3 of 3 points\n"
    command.interrupt()
    ended = command.ended()
    assert (ended.status, ended.left) == (130, [])
    assert "interrupted: what was graded is kept; the same command continues\n" in ended.errors
    (tmp_path / "class" / "b.py").write_text(source("1 / 0"))
    done = Command(tmp_path, words).ended()
    assert (done.status, "b: 0 of 3 points" in done.output) == (0, True)
    assert "a: 3 of 3 points, as graded before\n" in done.output
    assert marks_in(tmp_path / "class_spec_grades")["b"]["points"] == "0"


@pytest.mark.parametrize("failures", [1, 2, 3])
def test_a_failure_on_our_side_is_tried_again_and_costs_no_other_submission(tmp_path, monkeypatch, failures):
    monkeypatch.setattr(block_queue, "_PAUSE_S", 0.0)
    write_class(tmp_path, {"a.py": GOOD, "b.py": GOOD, "c.py": GOOD})
    submissions, _ = find_submissions(tmp_path / "class")
    tried = []

    def grade(submission):
        tried.append(submission.name)
        if submission.name == "a" and tried.count("a") <= failures:
            raise MatchFailedError("the disk is full")
        return Graded(name=submission.name, digest="", grades=())

    executor = Executor()
    found = {one.name: one.fault for one, _ in grade_class(submissions, grade, executor, tmp_path / "out", "key")}
    assert found == {"a": "the disk is full" if failures == 3 else None, "b": None, "c": None}
    assert sorted(tried) == ["a"] * min(3, 1 + failures) + ["b", "c"]
    again = [(one.name, known) for one, known in grade_class(submissions, grade, executor, tmp_path / "out", "key")]
    assert sorted(again) == [("a", failures < 3), ("b", True), ("c", True)]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["class", "--trusted"], "--trusted must be left out with a class"),
        (["class", "--json", "g.json"], "--junit and --json must be left out with a class"),
        (["class", "--out", "class/out"], "--out must be outside of the submissions' folder"),
        (["class", "--bus", "rclpy"], "--bus must come with the service of a node"),
        (["class/a.py", "--deadline", "2026-11-30"], "--deadline must come with a folder of submissions"),
        (["class/a.py", "--jobs", "2"], "--jobs must come with a folder of submissions"),
        (["empty"], "has no submission"),
        (["class", "--out", "other"], "marks.csv: already exists; use --force"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(tmp_path, monkeypatch, words, message):
    write_class(tmp_path, {"a.py": GOOD})
    monkeypatch.chdir(tmp_path)
    Path("empty").mkdir()
    Path("other").mkdir()
    Path("other/marks.csv").write_text("mine")
    result = call(*words, "--spec", "spec.toml")
    assert (result.exit_code, message in result.stderr) == (2, True), result.output
    assert len(result.stderr.splitlines()) == 1
    assert Path("other/marks.csv").read_text() == "mine"


def test_a_class_needs_a_seed_that_stays(tmp_path, monkeypatch):
    write_class(tmp_path, {"a.py": GOOD})
    monkeypatch.chdir(tmp_path)
    Path("spec.toml").write_text(re.sub("seed = .*\n", "", SPEC))
    result = call("class", "--spec", "spec.toml")
    assert (result.exit_code, "a class needs seed or seed_file" in result.stderr) == (2, True)


def test_a_link_that_leads_nowhere_costs_only_itself(tmp_path, monkeypatch):
    write_class(tmp_path, {"a.py": GOOD})
    monkeypatch.chdir(tmp_path)
    Path("class/b.py").symlink_to("missing.py")
    result = call("class", "--spec", "spec.toml", "--jobs", "1")
    assert result.exit_code == 0, result.output
    marks = marks_in(Path("class_spec_grades"))
    assert (marks["a"]["points"], marks["b"]["points"]) == ("3", "0")
    assert "is a link that leads to no file" in marks["b"]["reason"]


def test_the_name_of_a_test_may_be_any_text(tmp_path, monkeypatch):
    """A replay's title, which has it, has at most 200 printable characters."""
    write_class(tmp_path, {"a.py": GOOD})
    monkeypatch.chdir(tmp_path)
    Path("spec.toml").write_text(SPEC.replace('"alone"', f'"{"long " * 50}\\u001b"'))
    result = call("class", "--spec", "spec.toml", "--jobs", "1")
    assert result.exit_code == 0, result.output
    assert "a: 3 of 3 points" in result.stdout


def test_two_submissions_with_one_name_are_refused(tmp_path):
    write_class(tmp_path, {"ann.py": GOOD, "Ann/agent.py": GOOD})
    with pytest.raises(ConfigError, match=r"Ann and ann\.py have one name"):
        find_submissions(tmp_path / "class")


def test_weights_and_hidden_files_are_no_submissions_and_dates_are_those_of_the_files(tmp_path):
    files = {"ann.py": GOOD, "ann.npz": "", "ben/agent.py": GOOD, "ben/.git/x": "", "__MACOSX/x.py": "", ".x.py": ""}
    write_class(tmp_path, {**files, "notes.txt": ""})
    os.utime(tmp_path / "class" / "ben" / ".git" / "x", (2e9, 2e9))
    found, others = find_submissions(tmp_path / "class")
    assert ([one.name for one in found], others) == (["ann", "ben"], ["notes.txt"])
    assert {one.changed for one in found} == {datetime.fromtimestamp(1e9).astimezone()}


def test_the_pages_of_a_league_in_the_same_folder_are_no_submission(tmp_path):
    """A student may be called site if there is no league."""
    write_class(tmp_path, {"ann.py": GOOD, "site/agent.py": GOOD})
    assert [one.name for one in find_submissions(tmp_path / "class")[0]] == ["ann", "site"]
    (tmp_path / "class" / ".league").mkdir()
    found, others = find_submissions(tmp_path / "class")
    assert ([one.name for one in found], others) == (["ann"], ["site"])
