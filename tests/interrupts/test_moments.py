"""Interrupted commands print one line, exit with 130, leave no process behind, and lose no match that was played."""

import re
import time
from pathlib import Path

import pytest
from command_line import run
from interrupts.commands import LINE, WAITS_WHEN_IT_HAS_KEPT, Command

from catch_arena.tournament.store import Store

ROOT = Path(__file__).parents[2]
TOURNAMENT = (
    "tournament",
    "mine.py",
    "nearest",
    "-s",
    "duel",
    "--set",
    "time_limit_s=20",
    "--rounds",
    "6",
    "--seed",
    "0",
)
ISOLATED = (*TOURNAMENT, "--out", "o", "--jobs", "2", "--limit", "init_s=120", "--limit", "bank_s=120")
WATCHED = (*TOURNAMENT, "--out", "o", "--jobs", "1", "--trusted", "--watch")
MATCH = ("match", "mine.py", "nearest", "-s", "duel")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with an agent, and with the matches of the tournament when nothing interrupts it."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "mine.py").write_text((ROOT / "agents" / "contested.py").read_text())
    with pytest.MonkeyPatch.context() as here:
        here.chdir(folder)
        called(*TOURNAMENT, "--out", "o", "--trusted", "--jobs", "1")
        called("export", "o", "--no-timing", "-o", "matches.jsonl")
    return folder


def called(*words: str) -> str:
    done = run(*words)
    assert done.exit_code == 0, done.output
    return done.output


@pytest.fixture
def folder(made, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_bytes((made / "mine.py").read_bytes())
    return tmp_path


def line_of(command: Command) -> re.Match[str] | None:
    """The line of a command that was interrupted; None where it had ended."""
    ended = command.ended()
    assert not ended.left
    assert "Traceback" not in ended.output
    if ended.status == 130:
        line = LINE.fullmatch(ended.errors)
        assert line, ended.errors
        return line
    assert ended.errors == ""
    assert ended.status == 0
    return None


@pytest.mark.parametrize("words", [ISOLATED, WATCHED], ids=["isolated", "trusted, watched"])
def test_a_tournament_is_interrupted_after_its_first_block_and_goes_on_from_there(words, folder, made):
    command = Command(folder, words, WAITS_WHEN_IT_HAS_KEPT)
    while not (folder / "kept").exists() and command.process.poll() is None:
        time.sleep(0.01)
    command.interrupt([0.05])
    assert line_of(command)["kept"]
    with Store.read(folder / "o") as store:
        assert store.count_played() == 2
    again = called(*(word for word in words if word != "--watch"), "--resume")
    assert "results: o" in again
    called("export", "o", "--no-timing", "-o", "matches.jsonl")
    assert (folder / "matches.jsonl").read_bytes() == (made / "matches.jsonl").read_bytes()


@pytest.mark.parametrize("words", [("play", "--help"), MATCH], ids=["help", "match"])
def test_a_command_is_interrupted_when_it_has_just_begun(words, folder):
    before = {path.name for path in folder.iterdir()}
    command = Command(folder, words)
    command.wait_until_it_listens()
    command.interrupt([0.05])
    line_of(command)
    assert {path.name for path in folder.iterdir()} - before <= {"match.replay"}  # it may have ended
