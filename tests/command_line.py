"""`catch-arena` in the process of the tests."""

from typer.main import get_command
from typer.testing import CliRunner

from catch_arena.cli import main


def run(*words: object, columns: int | None = None):
    """`catch-arena WORDS`, on a terminal of that width: its exit code, and what it printed."""
    terminal = {"COLUMNS": str(columns)} if columns else {}
    return CliRunner(env=terminal).invoke(main, [str(word) for word in words])


def commands(group=None, words=()):
    """Yield the words of each command, and the command."""
    for name, command in (group or get_command(main)).commands.items():
        if hasattr(command, "commands"):
            yield from commands(command, (*words, name))
        else:
            yield [*words, name], command
