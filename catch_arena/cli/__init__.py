"""The command line: a file for each group of commands. Each checks its options, calls the library, and says where
the results are.

- app: the application, its errors, and the options that commands share.
- The commands: matches (tournament, match), hand_ins (check-agent, grade), evaluation (compare), suite,
  live (play, watch), replays (verify, diff, explain), videos (render, mosaic, highlights),
  report, exports (export), conformance, listings (agents, scenarios), ros and ros_bags.
- ros_nodes: what conformance and grade do with a node on a ROS 2 bus. bus_options: which bus that is.
- arguments: secrets on the command line. usage_errors: errors of the command line in one line. outputs: files that are
  not replaced unless told to.
- terminal, tables, fitted_table, progress, live_standings: what a terminal shows.
"""

from catch_arena.cli import conformance as _conformance  # noqa: F401
from catch_arena.cli import evaluation as _evaluation  # noqa: F401
from catch_arena.cli import exports as _exports  # noqa: F401
from catch_arena.cli import hand_ins as _hand_ins  # noqa: F401
from catch_arena.cli import listings as _listings  # noqa: F401
from catch_arena.cli import live as _live  # noqa: F401
from catch_arena.cli import matches as _matches  # noqa: F401
from catch_arena.cli import replays as _replays  # noqa: F401
from catch_arena.cli import report as _report  # noqa: F401
from catch_arena.cli import ros as _ros  # noqa: F401
from catch_arena.cli import ros_bags as _ros_bags  # noqa: F401
from catch_arena.cli import suite as _suite  # noqa: F401
from catch_arena.cli import videos as _videos  # noqa: F401
from catch_arena.cli.app import arena, main

__all__ = ["arena", "main"]
