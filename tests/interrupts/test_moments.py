"""Interrupts of whole commands: one line, status 130, nothing left behind, nothing lost.

They come at chosen events, and by night at random moments of a command's whole life. The moments follow from their
numbers: a failure is repeated by its number, as far as the machine repeats itself.
"""

import random
import re
import time
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import pytest
from interrupts.commands import LINE, WAITS_WHEN_IT_HAS_KEPT, Command
from typer.testing import CliRunner

from catch_arena.cli import main

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
COMMANDS = {
    "isolated": ISOLATED,
    "trusted, watched": WATCHED,
    "match": ("match", "mine.py", "nearest", "-s", "duel"),
    "render": ("render", "m.replay", "--size", "320x320", "--fps", "20"),
    "verify": ("verify", "m.replay"),
    "grade": ("grade", "mine.py", "--spec", "spec.toml", "--junit", "grades.xml"),
    "check-agent": ("check-agent", "mine.py", "--scenario", "duel"),
    "conformance": ("conformance", "catch_arena:arbitrate"),
    "compare": ("compare", "mine.py", "nearest", "--max-blocks", "4"),
}
UNDISTURBED = {0, 1, 3}
"""How they end: 1 and 3 are what `compare` says of few matches."""
SPEC = """
title = "An exercise"
seed = 1
matches = 3
[[test]]
name = "catches"
scenario = "duel"
opponents = ["idle"]
min_mean_score = 1
"""


def moment(number: int) -> tuple[float, list[float]]:
    """When the first signal comes, as a share of the command's life, and the pauses [s] before each further one."""
    draw = random.Random(number)
    signals = draw.choice([1, 2, 12])
    return draw.uniform(0.0, 1.05), [draw.uniform(0.0, 0.3 if signals == 2 else 0.1) for _ in range(signals - 1)]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with what the commands read; and the tournament's matches, had it not been disturbed."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "mine.py").write_text((ROOT / "agents" / "contested.py").read_text())
    (folder / "spec.toml").write_text(SPEC)
    with pytest.MonkeyPatch.context() as here:
        here.chdir(folder)
        called("match", "mine.py", "nearest", "-s", "duel", "--trusted", "-o", "m.replay")
        called(*TOURNAMENT, "--out", "o", "--trusted", "--jobs", "1")
        called("export", "o", "--no-timing", "-o", "matches.jsonl")
    return folder


def called(*words: str) -> str:
    done = CliRunner().invoke(main, list(words))
    assert done.exit_code == 0, done.output
    return done.output


def copied(made: Path, folder: Path) -> Path:
    """A folder with the same to read."""
    for name in ("mine.py", "spec.toml", "m.replay"):
        (folder / name).write_bytes((made / name).read_bytes())
    return folder


@pytest.fixture
def folder(made, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return copied(made, tmp_path)


@cache
def life_s(words: tuple[str, ...], made: Path) -> float:
    """How long a command takes undisturbed, from when it listens."""
    command = Command(copied(made, Path(mkdtemp(dir=made))), words)
    command.wait_until_it_listens()
    begin = time.monotonic()
    assert command.ended().status in UNDISTURBED
    return time.monotonic() - begin


def line_of(command: Command) -> re.Match[str] | None:
    """The line of a command that was interrupted; None where it had ended."""
    ended = command.ended()
    assert not ended.left
    assert "Traceback" not in ended.said
    if ended.status == 130:
        line = LINE.fullmatch(ended.errors)
        assert line, ended.errors
        return line
    assert ended.errors == ""
    assert ended.status in UNDISTURBED
    return None


@pytest.mark.parametrize("words", [ISOLATED, WATCHED], ids=["isolated", "trusted, watched"])
def test_a_tournament_is_interrupted_after_its_first_block_and_goes_on_from_there(words, folder, made):
    command = Command(folder, words, WAITS_WHEN_IT_HAS_KEPT)
    while not (folder / "kept").exists() and command.process.poll() is None:
        time.sleep(0.01)
    command.interrupt([0.05])
    assert line_of(command)["kept"] == "2"
    require_the_same_when_it_goes_on(words, folder, made)


@pytest.mark.parametrize("words", [("play", "--help"), COMMANDS["match"]], ids=["help", "match"])
def test_a_command_is_interrupted_when_it_has_just_begun(words, folder):
    before = {path.name for path in folder.iterdir()}
    command = Command(folder, words)
    command.wait_until_it_listens()
    command.interrupt([0.05])
    line_of(command)
    assert {path.name for path in folder.iterdir()} - before <= {"match.replay"}  # it may have ended


def require_the_same_when_it_goes_on(words: tuple[str, ...], folder: Path, made: Path) -> None:
    again = called(*(word for word in words if word != "--watch"), "--resume")
    assert "results: o" in again
    called("export", "o", "--no-timing", "-o", "matches.jsonl")
    assert (folder / "matches.jsonl").read_bytes() == (made / "matches.jsonl").read_bytes()


@pytest.mark.nightly
@pytest.mark.parametrize("number", range(100))
def test_any_command_is_interrupted_at_any_moment_and_leaves_nothing_half_done(number, folder, made):
    before = {path.name for path in folder.iterdir()}
    words = list(COMMANDS.values())[number % len(COMMANDS)]
    share, pauses = moment(number)
    wait_s = share * life_s(tuple(word for word in words if word != "--watch"), made)
    command = Command(folder, words)
    command.wait_until_it_listens()
    time.sleep(wait_s)
    command.interrupt(pauses)
    line = line_of(command)
    left = {path.name for path in folder.iterdir()} - before
    assert left <= {"match.replay", "m.mp4", "grades.xml", "out", "o"}  # those that are whole
    if words[0] != "tournament":
        assert line is None or line["kept"] is None
    elif line is not None and line["kept"] is None:
        assert not list(folder.glob("o/*.csv"))
    else:
        require_the_same_when_it_goes_on(words, folder, made)
