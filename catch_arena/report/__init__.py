"""What a tournament found, as one page: DIR/report.html. docs/report.md has the rest.

- data: what a tournament's folder holds. selection: which replays stand in the page. charts: figures.
- page: the page itself. watch: the page of a tournament that is under way, served on this machine.
"""

from catch_arena.report.page import BUDGET, REPORT, write_report

__all__ = ["BUDGET", "REPORT", "write_report"]
