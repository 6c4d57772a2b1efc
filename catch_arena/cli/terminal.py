"""What the terminal can show: its letters and its width."""

import codecs
import os
import shutil
import sys
from inspect import cleandoc
from io import TextIOWrapper
from typing import Any, Final

WIDE: Final = 80
"""So many columns hold our tables and the help's boxes."""
_LEAST: Final = 20
_INDENT: Final = 6
"""Of the explanations on a narrow terminal."""


def columns() -> int:
    """Of the terminal, or as COLUMNS says, and no fewer than words need; WIDE for a file."""
    return max(_LEAST, shutil.get_terminal_size((WIDE, 24)).columns)


def let_all_be_written() -> None:
    """No letter is a reason to stop. Under LANG=C the output becomes UTF-8, as Python would have it by itself and as
    typer.echo writes in any case; elsewhere, and where PYTHONIOENCODING asks for ASCII, there is a question mark for
    what cannot be shown.
    """
    asked = "PYTHONIOENCODING" in os.environ
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            encoding = codecs.lookup(stream.encoding).name
            if encoding == "ascii" and not asked:
                encoding = "utf-8"
            stream.reconfigure(encoding=encoding, errors="surrogateescape" if encoding == "utf-8" else "replace")


def fit_help(command: Any) -> None:
    """On a narrow terminal the help of a command, and of those below it, has no boxes, which would cut its words off:
    each option stands in a line of its own, and is explained below.
    """
    width = columns()
    if width >= WIDE:
        return
    formatter = command.context_class.formatter_class

    class Narrow(formatter):  # type: ignore[misc, valid-type]
        def write_dl(self, rows: Any, *_: Any, **__: Any) -> None:
            super().write_dl(rows, 1, _INDENT - 1)

    command.context_class = type("Context", (command.context_class,), {"formatter_class": Narrow})
    command.context_settings = {**command.context_settings, "terminal_width": width}
    command.rich_markup_mode = None
    command.short_help = cleandoc(command.help or "").partition("\n\n")[0].replace("\n", " ")
    for one in getattr(command, "commands", {}).values():
        fit_help(one)
