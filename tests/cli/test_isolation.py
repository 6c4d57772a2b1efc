"""The command line says how agents are isolated, refuses a level that does not work, and hides its own files."""

from pathlib import Path

import pytest
from isolation_levels import LEVELS, NAMESPACES
from typer.testing import CliRunner

from catch_arena.cli import main
from catch_arena.tournament.isolation.namespaces import level_line

QUICK = ["--scenario", "duel", "--set", "time_limit_s=1"]
AGENT = """
from pathlib import Path

HERE = Path(__file__).parent


class Agent:
    def reset(self, seed):
        print(sorted(path.name for path in HERE.iterdir()))

    def act(self, view):
        return 0
"""
SPEC = """
seed_file = "seeds.txt"

[[test]]
name = "plays"
scenario = "duel"
settings = { time_limit_s = 1 }
opponents = ["idle"]
"""


@pytest.fixture
def catch_arena(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(AGENT)

    def call(*words: str):
        return CliRunner().invoke(main, list(words))

    return call


def unfolded(text):
    return " ".join(text.split())


def commands(*agents):
    return [
        ["match", *agents, *QUICK],
        ["tournament", *agents, "--rounds", "1", *QUICK, "--jobs", "1"],
        ["compare", *agents, *QUICK, "--jobs", "1", "--max-blocks", "2"],
    ]


@pytest.mark.parametrize("number", range(3))
def test_each_command_says_in_one_line_which_level_holds(catch_arena, number):
    for level in LEVELS:
        asked = [] if level == LEVELS[0] else ["--limit", f"isolation={level}"]
        result = catch_arena(*commands("mine.py", "idle")[number], *asked, "--force" if number == 0 else "--seed=1")
        assert result.exit_code in {0, 1, 3}, result.output
        assert unfolded(result.stderr).startswith(level_line(level))
        assert result.stderr.count("isolation:") == 1
        if number == 1:
            break  # its folder holds the first one


def test_check_agent_and_grade_say_it_too(catch_arena, tmp_path):
    (tmp_path / "exam.toml").write_text(SPEC)
    (tmp_path / "seeds.txt").write_text("1")
    for words in (["check-agent", "mine.py", *QUICK], ["grade", "mine.py", "--spec", "exam.toml"]):
        assert level_line(LEVELS[0]) in unfolded(catch_arena(*words).stderr)


def test_nothing_is_said_where_all_are_trusted(catch_arena):
    for words in (["mine.py", "idle", "--trusted"], ["nearest", "idle", "--force"]):
        played = catch_arena("match", *words, *QUICK)
        assert played.exit_code == 0, played.output
        assert "isolation" not in played.stderr


def test_a_level_that_cannot_be_held_is_refused_before_anything_is_written(catch_arena, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    for words in commands("nearest", "idle"):
        refused = catch_arena(*words, "--limit", "isolation=namespaces")
        assert (refused.exit_code, refused.stderr.count("\n")) == (2, 1)
        assert refused.stderr.startswith("error: isolation namespaces cannot be held here: bubblewrap is not in")
    assert [path.name for path in tmp_path.iterdir()] == ["mine.py"]
    told = unfolded(catch_arena("match", "mine.py", "idle", *QUICK).stderr)
    assert told.startswith(level_line("processes"))


def test_a_level_that_is_none_is_refused(catch_arena):
    refused = catch_arena("match", "nearest", "idle", *QUICK, "--limit", "isolation=x")
    assert refused.stderr == "error: isolation must be one of namespaces, processes, got 'x'\n"


@pytest.mark.parametrize("level", NAMESPACES)
def test_no_agent_sees_what_the_command_writes_or_is_given(catch_arena, tmp_path, level):
    (tmp_path / "theirs.py").write_text(AGENT)
    (tmp_path / "mine.npz").touch()
    catch_arena(
        *("tournament", "mine.py", "theirs.py", "--rounds", "1", *QUICK),
        *("--jobs", "1", "--record", "--limit", f"isolation={level}"),
    )
    logs = [path.read_text() for path in Path("out/tournament/logs").rglob("*") if path.is_file()]
    assert any("['mine.npz', 'mine.py']" in log for log in logs)
    assert any("['theirs.py']" in log for log in logs)
    assert not any("'out" in log for log in logs)


@pytest.mark.parametrize("level", NAMESPACES)
def test_no_agent_sees_the_spec_that_it_is_graded_by_nor_its_seeds(catch_arena, tmp_path, level):
    (tmp_path / "exam.toml").write_text(SPEC)
    (tmp_path / "seeds.txt").write_text("1")
    (tmp_path / "mine.py").write_text(
        AGENT.replace("return 0", "raise ValueError([path.name for path in HERE.iterdir()])")
    )
    graded = catch_arena("grade", "mine.py", "--spec", "exam.toml", "--limit", f"isolation={level}")
    assert "ValueError: ['mine.py']" in graded.stdout
    assert Path("exam.toml").exists()
