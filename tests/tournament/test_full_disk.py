"""A store that cannot grow ends a tournament with one line and exit code 2, and `--resume` continues it."""

import re
import resource
from contextlib import contextmanager
from pathlib import Path

from interrupts.commands import PROGRESS

from catch_arena.tournament.store import Store

QUICK = ["--scenario", "duel", "--set", "time_limit_s=3"]
TOURNAMENT = ["tournament", "nearest", "idle", *QUICK, "--rounds", "150", "--seed", "0", "--jobs", "1"]
KEPT = "what was played is kept in {}; the same command with --resume goes on"


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


def test_a_store_that_cannot_grow_is_one_line_and_is_resumed(catch_arena):
    with files_of_at_most(140_000):
        stopped = catch_arena(*TOURNAMENT, "--out", "o")
    assert stopped.exit_code == 2
    error = re.fullmatch(
        rf"error: o/tournament\.sqlite: cannot be used: disk I/O error; {KEPT.format('o')}\n",
        PROGRESS.sub("", stopped.stderr),
    )
    assert error, stopped.stderr
    with Store.read(Path("o")) as store:
        assert 0 < store.count_played() < 300
    assert catch_arena(*TOURNAMENT, "--out", "o", "--resume").exit_code == 0
    assert catch_arena(*TOURNAMENT, "--out", "undisturbed").exit_code == 0
    assert exported(catch_arena, "o") == exported(catch_arena, "undisturbed")
