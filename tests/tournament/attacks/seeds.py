"""Attacks on the seed of a match, from which all its targets follow."""

import sqlite3
from contextlib import closing
from pathlib import Path

from tournament.attacks.kit import FACTS, ancestors, tell


def works_out_the_matchs_seed_from_its_own(own):
    """With the tournament's own functions, for all seeds that people like to type."""
    from catch_arena.tournament.plans.schedule import plan_of
    from catch_arena.tournament.secret import agent_seed

    for seed in range(100):
        for match in next(iter(plan_of("round-robin", 2, 2, 1, seed).stage(0, ()))):
            told = getattr(match, "agent_seeds", ()) or [agent_seed(match.seed, one) for one in match.seating]
            if own.seed in told:
                tell(f"the seed {match.seed}")


def works_out_a_seed_that_was_short(own):
    """That was given by --seed 7."""
    works_out_the_matchs_seed_from_its_own(own)


def reads_the_seeds_in_the_store(own):
    with closing(sqlite3.connect(f"file:{FACTS['out']}/tournament.sqlite?mode=ro", uri=True)) as store:
        for (table,) in store.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall():
            for row in store.execute(f"SELECT * FROM {table}").fetchall():
                tell([value % 2**64 if isinstance(value, int) else value for value in row])


def reads_the_seed_in_the_tournaments_command_line(own):
    for pid in ancestors():
        words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
        if b"--seed" in words:
            tell(f"the seed {words[words.index(b'--seed') + 1].decode()}")
