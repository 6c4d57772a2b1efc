"""What a tournament found, as one page: DIR/report.html. docs/report.md has the rest."""

from catch_arena.report.page import BUDGET, REPORT, write_report

__all__ = ["BUDGET", "REPORT", "write_report"]
