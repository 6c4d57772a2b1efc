"""`catch-arena` in the process of the tests."""

from typer.testing import CliRunner

from catch_arena.cli import main


def run(*words: object, columns: int | None = None):
    """`catch-arena WORDS`, on a terminal of that width: its exit code, and what it printed."""
    terminal = {"COLUMNS": str(columns)} if columns else {}
    return CliRunner(env=terminal).invoke(main, [str(word) for word in words])
