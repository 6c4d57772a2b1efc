"""Command line, with a file for each group of commands. Each command checks its options, calls the library, and prints
the paths of its results.

- app: the application, its errors and exit codes. options, bus: the options that commands share.
- The commands: matches (match, play, watch), tournaments (tournament, compare, report, export), league, suite, hand_ins
  (new-agent, check-agent, grade, new-class), conformance, replays (verify, diff, explain, render, clip, mosaic,
  highlights), listings (agents, scenarios, docs) and ros.
- class_grading: the grades of a class. outputs: files that are not replaced without --force. terminal, tables: output
  on a terminal.
"""

from catch_arena.cli import conformance, hand_ins, league, listings, matches, replays, ros, suite, tournaments  # noqa: F401
from catch_arena.cli.app import main

__all__ = ["main"]
