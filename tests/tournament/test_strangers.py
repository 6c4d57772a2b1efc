"""Hostile text from agents harms no terminal, log, report, export or grade."""

import csv
import json
import os
import pty
import re
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from xml.etree import ElementTree as ET

import command_line
import pytest
from tournament.agents import write_agent

import catch_arena
from catch_arena import scenario
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match_loop import play_entrants
from catch_arena.tournament.players import enter
from catch_arena.tournament.store import STORE

QUICK = ["--scenario", "duel", "--set", "time_limit_s=1"]
PATIENCE = ["--limit", "init_s=120", "--limit", "bank_s=120"]
WORDS = [
    *("tournament", "[red]x.py", "=1+1.py", "nearest", "--rounds", "1", *QUICK, *PATIENCE),
    *("--jobs", "1", "--record", "--out", "out"),
]
SHORT = scenario("duel", time_limit_s=1)
HOSTILE = r"""
import sys
print("\x1b[31mred\x1b[0m \x07 \u202e abc [bold]x[/bold]")
class Agent:
    def reset(self, seed):
        sys.stdout.buffer.write(b"\xff\x00\x1b]0;title\x07\n")
    def act(self, view):
        raise RuntimeError("\ud800 \x1b[2J \x00 \u202e <script>alert(1)</script> ]]> [red]")
"""
SHOWN = r"act raised RuntimeError: \ud800 \x1b[2J \x00 \u202e <script>alert(1)</script> ]]> [red]"
LINES = [
    rb'{"error":"\ud800 \u001b[2J \u0000"}',
    b'{"error":{"a":[[[[1]]]]}}',
    b'{"error":' + b"[" * 900 + b"]" * 900 + b"}",
    rb'{"action":"\ud800"}',
    b'{"action":' + b"9" * 9000 + b"}",
    b'{"action":' + b"[" * 30000 + b"}",
    b'{"action":NaN}',
    b'{"action":1e999}',
    b'{"a":' + b"[" * 940 + b"]" * 940 + b"}",
    rb'{"action":{"cmd_vel":["\ud800",1],"catch":null}}',
    b"\xff\xfe\x00",
    b"\x1b[2J",
    b"null",
    b"",
]
"""Actions that an agent may answer."""


def run(folder, *words):
    """A command of the package that is tested, in that folder."""
    environment = os.environ | {"PYTHONPATH": str(Path(catch_arena.__file__).parents[1])}
    environment.pop("COLUMNS", None)  # by which lines would be folded
    command = [sys.executable, "-m", "catch_arena", *words]
    return subprocess.run(command, cwd=folder, capture_output=True, check=False, env=environment)


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """A tournament with such an agent, whose file's name is markup."""
    folder = tmp_path_factory.mktemp("hostile")
    (folder / "[red]x.py").write_text(HOSTILE)
    (folder / "=1+1.py").write_text(HOSTILE)
    ended = run(folder, *WORDS)
    assert ended.returncode == 0, ended.stderr.decode()
    return folder, ended


def test_the_tournament_ends_and_the_terminal_is_sent_no_control_character(played):
    _, ended = played
    assert re.search(r"^ *\d +\[red\]x ", ended.stdout.decode(), re.MULTILINE)
    for output in (ended.stdout, ended.stderr):
        assert all(letter.isprintable() or letter == "\n" for letter in output.decode())


def test_its_logs_show_what_was_printed_and_raised(played):
    folder, _ = played
    text = (folder / "out/logs/[red]x.log").read_text(encoding="utf-8")
    assert f"FORFEIT_CRASH in step 1: {SHOWN}\n" in text
    assert "\\xff\\x00\\x1b]0;title\\x07\n" in text
    assert all(letter.isprintable() or letter in "\n\t" for letter in text)


def test_its_store_and_its_exports_hold_it_and_no_cell_is_a_formula(played):
    folder, _ = played
    with closing(sqlite3.connect(folder / "out" / STORE)) as db:
        played = [json.loads(text) for (text,) in db.execute("SELECT played FROM match")]
    assert SHOWN in {one[2] for match in played for one in match["result"]["forfeits"] if one}
    for form in ("jsonl", "csv"):
        assert run(folder, "export", "out", "-o", f"m.{form}", "--force").returncode == 0
    rows = [json.loads(line) for line in (folder / "m.jsonl").read_text(encoding="utf-8").splitlines()]
    assert {name for one in rows for name in one["agents"]} == {"[red]x", "=1+1", "nearest"}
    for table in (folder / "m.csv", folder / "out/standings.csv"):
        with table.open(newline="") as file:
            assert {row["agent"] for row in csv.DictReader(file)} == {"[red]x", "'=1+1", "nearest"}


def test_its_report_is_text(played):
    folder, _ = played
    text = (folder / "out/report.html").read_text(encoding="utf-8")
    assert "<script>alert" not in text
    assert "&lt;script&gt;alert(1)" in text
    assert str(folder) not in text


@pytest.mark.parametrize(
    "words",
    [["explain", "{}"], ["verify", "{}"], ["render", "{}", "-o", "m.gif", "--size", "320x320"], [*WORDS, "--resume"]],
    ids=lambda words: words[0],
)
def test_its_replays_are_explained_and_filmed_and_it_goes_on(played, words):
    folder, _ = played
    replay = min((folder / "out/replays").glob("*.replay"))
    ended = run(folder, *(word.replace("{}", str(replay)) for word in words))
    assert ended.returncode == 0, ended.stderr.decode()


def test_a_mark_is_xml_and_json_and_one_line_each(played):
    folder, _ = played
    spec = 'seed = 1\n[[test]]\nname = "a\\u001bb"\nscenario = "duel"\nopponents = ["idle"]\nmatches = 1\n'
    (folder / "spec.toml").write_text(spec)
    outputs = ("--junit", "g.xml", "--json", "g.json", "--force")
    ended = run(folder, "grade", "[red]x.py", "--spec", "spec.toml", *outputs, *PATIENCE)
    assert ended.returncode == 1, ended.stderr.decode()
    assert all(letter.isprintable() or letter == "\n" for letter in ended.stdout.decode())
    (case,) = ET.parse(folder / "g.xml").getroot().iter("testcase")  # noqa: S314 - ours
    assert (case.get("classname"), case.get("name")) == ("[red]x", r"a\x1bb")
    assert SHOWN in case.find("failure").text
    (failure,) = json.loads((folder / "g.json").read_text())["tests"][0]["failures"]
    assert SHOWN in failure


def test_a_real_terminal_is_sent_none_of_its_commands(played):
    """A pipe proves little: what is printed through one loses its colours in any case."""
    folder, _ = played
    ours, theirs = pty.openpty()
    environment = os.environ | {"PYTHONPATH": str(Path(catch_arena.__file__).parents[1]), "TERM": "xterm-256color"}
    words = ["match", "[red]x.py", "nearest", *QUICK, *PATIENCE, "-o", "t.replay", "--force"]
    words = [sys.executable, "-m", "catch_arena", *words]
    sent = b""
    with subprocess.Popen(words, cwd=folder, stdin=theirs, stdout=theirs, stderr=theirs, env=environment):
        os.close(theirs)
        try:
            while part := os.read(ours, 65536):
                sent += part
        except OSError:  # the other end is closed
            os.close(ours)
    assert rb"\x1b]0;title\x07" in sent
    assert SHOWN.encode() in sent
    for command in (b"\x1b]0;", b"\x07", b"\x1b[31mred", b"\x1b[2J", b"\0", "\u202e".encode()):
        assert command not in sent


@pytest.fixture(scope="module")
def sandbox():
    with Sandbox(Quotas(init_s=60, step_ms=60_000)) as made:
        yield made


@pytest.mark.parametrize("line", LINES)
def test_whatever_it_answers_is_its_forfeit_and_nothing_else(sandbox, tmp_path, line):
    """The agent writes to the pipe itself."""
    source = (
        "for file in range(3, 64):\n    with suppress(OSError):\n"
        f"        os.write(file, {line!r} + b'\\n')\nos._exit(0)"
    )
    path = write_agent(tmp_path / "answers.py", source, before="import os\nfrom contextlib import suppress\n")
    entrants = enter([path, "nearest"], sandbox)
    result = play_entrants(SHORT, 3, entrants, sandbox)
    assert result.forfeit_codes[1] is None
    assert result.forfeits[0].reason.isprintable()
    assert len(result.forfeits[0].reason) <= 300


@pytest.mark.parametrize("name", ["x" * 101 + ".py", "\x1b[31m.py", "\u202ea.py", "a\tb.py"])
def test_a_name_that_cannot_be_shown_is_refused_in_one_line(tmp_path, name):
    (tmp_path / name).write_text(HOSTILE)
    words = ["tournament", str(tmp_path / name), "nearest", "--rounds", "1", *QUICK, "--out", str(tmp_path / "o")]
    ended = command_line.run(*words)
    assert ended.exit_code == 2
    assert ended.stderr.count("\n") == 1
    assert "its name must have 1 to 100 printable characters" in ended.stderr
    assert ended.stderr.replace("\n", "").isprintable()
    assert not (tmp_path / "o").exists()
