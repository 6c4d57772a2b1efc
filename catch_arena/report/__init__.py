"""Report of a tournament as one page, DIR/report.html; see docs/howto/report.md.

- data: the contents of a tournament's folder. selection: the replays in the page. charts: figures.
- lost_contests: what would have won contests that agents lost.
- page: the page itself. watch: the page of a tournament that is under way, served on this machine.
"""

from catch_arena.report.page import BUDGET, REPORT, write_report

__all__ = ["BUDGET", "REPORT", "write_report"]
