"""Command line, with a file for each group of commands. Each command checks its options, calls the library, and prints
the paths of its results.

- app: the application, its errors and exit codes. options, bus: the options that commands share.
- The commands: matches (tournament, match), league, hand_ins (new-agent, check-agent, grade, new-class), evaluation
  (compare), suite, live (play, watch), replays (verify, diff, explain), videos (render, clip, mosaic, highlights),
  results (report, export), conformance, listings (agents, scenarios, docs), ros and ros_bags.
- class_grading: the grades of a class. outputs: files that are not replaced without --force. terminal, tables,
  progress: output on a terminal.
"""

from catch_arena.cli import conformance as _conformance  # noqa: F401
from catch_arena.cli import evaluation as _evaluation  # noqa: F401
from catch_arena.cli import hand_ins as _hand_ins  # noqa: F401
from catch_arena.cli import league as _league  # noqa: F401
from catch_arena.cli import listings as _listings  # noqa: F401
from catch_arena.cli import live as _live  # noqa: F401
from catch_arena.cli import matches as _matches  # noqa: F401
from catch_arena.cli import replays as _replays  # noqa: F401
from catch_arena.cli import results as _results  # noqa: F401
from catch_arena.cli import ros as _ros  # noqa: F401
from catch_arena.cli import ros_bags as _ros_bags  # noqa: F401
from catch_arena.cli import suite as _suite  # noqa: F401
from catch_arena.cli import videos as _videos  # noqa: F401
from catch_arena.cli.app import main

__all__ = ["main"]
