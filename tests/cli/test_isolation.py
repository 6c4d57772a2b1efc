"""Each command prints its level of isolation, refuses one that does not work, and hides its own files."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from isolation_levels import LEVELS, NAMESPACES
from tournament.agents import write_agent

from catch_arena.tournament.isolation.namespaces import level_line

QUICK = ["--scenario", "duel", "--set", "time_limit_s=1"]
LISTS = "print(sorted(path.name for path in Path(__file__).parent.iterdir()))"
SPEC = """
seed_file = "seeds.txt"

[[test]]
name = "plays"
scenario = "duel"
settings = { time_limit_s = 1 }
opponents = ["idle"]
"""
PLAYS = {
    "match": [],
    "tournament": ["--rounds", "1", "--jobs", "1"],
    "compare": ["--jobs", "1", "--max-blocks", "2"],
}


@pytest.fixture(autouse=True)
def files(tmp_path):
    write_agent(tmp_path / "mine.py", reset=LISTS, before="from pathlib import Path\n")
    (tmp_path / "exam.toml").write_text(SPEC)
    (tmp_path / "seeds.txt").write_text("1")


def unfolded(text):
    return " ".join(text.split())


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize(
    "words",
    [
        *([command, "mine.py", "idle", *QUICK, *more] for command, more in PLAYS.items()),
        ["check-agent", "mine.py", *QUICK],
        ["grade", "mine.py", "--spec", "exam.toml"],
    ],
    ids=lambda words: words[0],
)
def test_each_command_says_in_one_line_which_level_holds(catch_arena, words, level):
    result = catch_arena(*words, *([] if level == LEVELS[0] else ["--limit", f"isolation={level}"]))
    assert result.exit_code in {0, 1, 3}, result.output
    assert unfolded(result.stderr).startswith(level_line(level))
    assert result.stderr.count("isolation:") == 1


def test_nothing_is_said_where_all_are_trusted(catch_arena):
    for words in (["mine.py", "idle", "--trusted"], ["nearest", "idle", "--force"]):
        played = catch_arena("match", *words, *QUICK)
        assert played.exit_code == 0, played.output
        assert "isolation" not in played.stderr


def test_a_level_that_cannot_be_held_is_refused_before_anything_is_written(catch_arena, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    before = sorted(tmp_path.iterdir())
    for command, more in PLAYS.items():
        refused = catch_arena(command, "nearest", "idle", *QUICK, *more, "--limit", "isolation=namespaces")
        assert (refused.exit_code, refused.stderr.count("\n")) == (2, 1)
        assert refused.stderr.startswith("error: isolation namespaces cannot be held here: bubblewrap is not in")
    assert sorted(tmp_path.iterdir()) == before
    stderr = unfolded(catch_arena("match", "mine.py", "idle", *QUICK).stderr)
    assert stderr.startswith(level_line("processes"))


@pytest.mark.skipif(not NAMESPACES, reason="bubblewrap hides /proc")
def test_processes_hold_on_a_machine_that_shows_no_proc(tmp_path):
    hidden = ["bwrap", "--bind", "/", "/", "--dev", "/dev", "--tmpfs", "/proc"]
    words = ["match", "mine.py", "idle", *QUICK, "--limit", "isolation=processes"]
    played = subprocess.run(
        [*hidden, sys.executable, "-m", "catch_arena", *words],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert played.returncode == 0, played.stderr
    assert "FORFEIT" not in played.stdout


@pytest.mark.parametrize("level", NAMESPACES)
def test_no_agent_sees_what_the_command_writes_or_is_given_nor_its_spec_and_seeds(catch_arena, tmp_path, level):
    (tmp_path / "theirs.py").write_text((tmp_path / "mine.py").read_text())
    (tmp_path / "mine.npz").touch()
    isolation = ("--limit", f"isolation={level}")
    catch_arena("tournament", "mine.py", "theirs.py", *QUICK, *PLAYS["tournament"], "--record", *isolation)
    logs = [path.read_text() for path in Path("out/tournament/logs").rglob("*") if path.is_file()]
    assert any("['mine.npz', 'mine.py']" in log for log in logs)
    assert any("['theirs.py']" in log for log in logs)
    assert not any("'out" in log for log in logs)
    write_agent(tmp_path / "theirs.py", f"{LISTS}; raise ValueError", before="from pathlib import Path\n")
    catch_arena("grade", "theirs.py", "--spec", "exam.toml", "--json", "grades.json", *isolation)
    (test,) = json.loads(Path("grades.json").read_text())["tests"]
    assert test["log"].startswith("['theirs.py']\n")
