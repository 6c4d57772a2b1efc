"""Command line, with a file for each group of commands. Each command checks its options, calls the library, and prints
the paths of its results.

- app: the application, its errors and exit codes. options, bus: the options that commands share.
- The commands: matches (match, play, watch), tournaments (tournament, compare, report, export), league, suite, hand_ins
  (new-agent, check-agent, grade, new-class), conformance, replays (verify, diff, explain, render, clip, mosaic,
  highlights), listings (agents, scenarios, docs) and ros.
- class_grading: the grades of a class. outputs: files that are not replaced without --force. terminal, tables: output
  on a terminal.
"""

from catch_arena.cli import conformance as _conformance  # noqa: F401
from catch_arena.cli import hand_ins as _hand_ins  # noqa: F401
from catch_arena.cli import league as _league  # noqa: F401
from catch_arena.cli import listings as _listings  # noqa: F401
from catch_arena.cli import matches as _matches  # noqa: F401
from catch_arena.cli import replays as _replays  # noqa: F401
from catch_arena.cli import ros as _ros  # noqa: F401
from catch_arena.cli import suite as _suite  # noqa: F401
from catch_arena.cli import tournaments as _tournaments  # noqa: F401
from catch_arena.cli.app import main

__all__ = ["main"]
