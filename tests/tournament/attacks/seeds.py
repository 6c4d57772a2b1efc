"""Attacks on the seed of a match, from which all its targets follow."""

import sqlite3
from pathlib import Path

from tournament.attacks.kit import FACTS, ancestors, tell


def works_out_the_matchs_seed_from_its_own(own):
    """With the tournament's own functions, for all seeds that people type."""
    from catch_arena.tournament.match import agent_seed
    from catch_arena.tournament.permutations import draw

    for seed in range(2000):
        match = draw("match", seed, 0, 0, 1)
        if own.seed in {agent_seed(match, 0), agent_seed(match, 1)}:
            tell(f"seed {match}")


def reads_the_seeds_in_the_store(own):
    with sqlite3.connect(f"file:{FACTS['out']}/tournament.sqlite?mode=ro", uri=True) as store:
        for (table,) in store.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall():
            for row in store.execute(f"SELECT * FROM {table}").fetchall():
                tell([value % 2**64 if isinstance(value, int) else value for value in row])


def reads_the_seed_in_the_tournaments_command_line(own):
    for pid in ancestors():
        words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
        if b"--seed" in words:
            tell(f"the seed {words[words.index(b'--seed') + 1].decode()}")
