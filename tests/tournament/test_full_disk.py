"""A full disk: one line with the folder and its room, exit code 2, nothing half-written, and `--resume` continues."""

import re
import resource
import subprocess
from contextlib import contextmanager

import pytest
from interrupts.commands import PROGRESS
from typer.testing import CliRunner

from catch_arena.cli import main

QUICK = ["--scenario", "duel", "--set", "time_limit_s=3"]
TOURNAMENT = ["tournament", "nearest", "idle", *QUICK, "--rounds", "150", "--seed", "0", "--jobs", "1"]
ROOM = r"[\d.]+ \w+ are free in [\w/]+"
KEPT = "of 300 matches are kept in {}; the same command with --resume goes on"


@pytest.fixture
def catch_arena(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def call(*words: str):
        return CliRunner().invoke(main, list(words))

    return call


@contextmanager
def files_of_at_most(size):
    """Writing beyond it fails as on a disk that is full, but for the words of the system."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def exported(catch_arena, folder):
    assert catch_arena("export", str(folder), "--no-timing", "-o", "matches.jsonl", "--force").exit_code == 0
    with open("matches.jsonl", "rb") as file:  # noqa: PTH123 - the working folder is the test's own
        return file.read()


def test_a_store_that_cannot_grow_says_how_much_is_free_and_needed_and_is_resumed(catch_arena):
    with files_of_at_most(140_000):
        stopped = catch_arena(*TOURNAMENT, "--out", "o")
    assert stopped.exit_code == 2
    error = re.fullmatch(
        rf"error: o/tournament\.sqlite: cannot be written: disk I/O error: {ROOM}, and [\d.]+ kB are needed; "
        rf"(?P<count>\d+) {KEPT.format('o')}\n",
        PROGRESS.sub("", stopped.stderr),
    )
    assert error, stopped.stderr
    assert 0 < int(error["count"]) < 300
    assert catch_arena(*TOURNAMENT, "--out", "o", "--resume").exit_code == 0
    assert catch_arena(*TOURNAMENT, "--out", "undisturbed").exit_code == 0
    assert exported(catch_arena, "o") == exported(catch_arena, "undisturbed")


@pytest.fixture
def small_disk(tmp_path):
    folder = tmp_path / "small"
    folder.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=400k", "tmpfs", folder], check=False, stderr=-3).returncode:
        pytest.skip("only root makes a small disk")
    yield folder
    subprocess.run(["umount", "--lazy", folder], check=True)  # FFmpeg lets go of a file late that it could not write


def test_a_disk_that_is_really_full(catch_arena, small_disk):
    catch_arena("match", "nearest", "idle", *QUICK, "-o", "m.replay")
    (small_disk / "mine.py").write_text(
        "class Agent:\n    def reset(self, seed): print('x' * 60_000)\n    def act(self, view): return 0\n"
    )
    recorded = [*TOURNAMENT, "--record", "--out", "small/o"]
    stopped = catch_arena(*recorded)
    assert stopped.exit_code == 2, stopped.output
    full = rf"cannot be written: the disk is full: {ROOM}"
    assert re.fullmatch(
        rf"error: small/o/.*{full}, and [\d.]+ \w+ are needed; \d+ {KEPT.format('small/o')}\n",
        PROGRESS.sub("", stopped.stderr),
    )
    left = sorted(small_disk.rglob("*"))
    for words in (
        ["match", "nearest", "idle", *QUICK, "-o", "small/m.replay"],
        ["render", "m.replay", "-o", "small/m.mp4", "--size", "320x320", "--fps", "10"],
        ["render", "m.replay", "-o", "small/m.gif", "--size", "320x320", "--fps", "10"],
        ["export", "small/o", "-o", "small/m.csv"],
        ["report", "small/o"],
        ["tournament", "small/mine.py", "idle", "--rounds", "1", *QUICK, "--jobs", "1", "--out", "small/p"],
    ):
        failed = catch_arena(*words)
        assert (failed.exit_code, "Traceback" in failed.output) == (2, False), failed.output
        *_, error = failed.stderr.splitlines()
        assert re.match(rf"error: small/.*{full}", error), error
    assert [path for path in sorted(small_disk.rglob("*")) if "small/p" not in str(path)] == left

    subprocess.run(["mount", "-o", "remount,size=20m", small_disk], check=True)
    assert catch_arena(*recorded, "--resume").exit_code == 0
    assert catch_arena(*TOURNAMENT, "--record", "--out", "undisturbed").exit_code == 0
    assert exported(catch_arena, small_disk / "o") == exported(catch_arena, "undisturbed")
