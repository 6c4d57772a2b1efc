"""What the terminal can show: its letters and its width."""

import codecs
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from inspect import cleandoc
from io import TextIOWrapper
from pathlib import Path
from textwrap import wrap
from typing import IO, Any, Final, cast

import typer
from rich.console import Console
from rich.file_proxy import FileProxy
from rich.text import Text

from catch_arena.streams import lasting
from catch_arena.text import printable, printable_lines

WIDE: Final = 80
"""So many columns hold our tables and the help's boxes."""
HELP_OPTIONS: Final = ("-h", "--help")
_LEAST: Final = 20
_OWN: Final[dict[bool, IO[str] | None]] = {}
"""Where this command prints, stdout at False and stderr at True: see `own_streams`."""
_FOLDER: Final[list[str]] = []
"""Where this command was started; also what an interrupt says after it has ended may name a path."""
_INDENT: Final = 6
"""Of the explanations on a narrow terminal."""


def say(text: str, *, err: bool = False) -> None:
    """Print lines, `err` on stderr. Control characters that a stranger's text may hold are shown, not sent."""
    typer.echo(printable_lines(_as_utf8(shown(text))), file=_stream(err=err), err=err)  # noqa: TID251 - here


def shown(text: str) -> str:
    """Shorten paths in a text that begin with our working folder, as they may be on the command line."""
    return re.sub(rf"(?<!\S){re.escape(_FOLDER[0])}{re.escape(os.sep)}", "", text) if _FOLDER else text


def own_console(*, err: bool = False) -> Console:
    """For tables and progress bars, on stdout or stderr."""
    return Console(file=_stream(err=err))


def _stream(*, err: bool) -> IO[str] | None:
    current: Any = sys.stderr if err else sys.stdout
    with suppress(AttributeError, OSError, ValueError):
        current.flush()  # what a trusted agent has printed comes first
    if isinstance(current, FileProxy):  # rich's, while it shows a bar
        return cast(IO[str], current)
    return _OWN.get(err, current)


def plain(text: str) -> Text:
    """A text that Rich shows as it stands, in a table's cell for instance: `[red]` is no markup in it."""
    return Text(printable(_as_utf8(text)))


def _as_utf8(text: str) -> str:
    """Under LANG=C Python reads a file's name byte by byte: the letters that these bytes are in UTF-8."""
    try:
        return text.encode("utf-8", "surrogateescape").decode()
    except UnicodeError:
        return text


def columns() -> int:
    """As COLUMNS says, or of the terminal, also where the output goes through a pipe, but no fewer than words need;
    WIDE where there is no terminal.
    """
    return _terminal_columns() or WIDE


def folded(text: str, first: str = "", then: str = "") -> str:
    """The text's lines, each with what begins the first one and all others; they fit the terminal, if there is one."""
    width = _terminal_columns()
    lines: list[str] = []
    for line in text.split("\n"):
        start = then if lines else first
        if width is None:
            lines.append(start + line)
        else:
            lines += wrap(
                line,
                width,
                initial_indent=start,
                subsequent_indent=then,
                break_long_words=False,
                break_on_hyphens=False,
            )
    return "\n".join(lines)


def _terminal_columns() -> int | None:
    asked = os.environ.get("COLUMNS", "")
    if asked.isdecimal() and int(asked):
        return max(_LEAST, int(asked))
    for stream in range(3):  # in the order in which Rich asks them for its tables and boxes
        with suppress(OSError):
            if width := os.get_terminal_size(stream).columns:
                return max(_LEAST, width)
    return None


@contextmanager
def own_streams() -> Iterator[None]:
    """Print to copies of stdout and stderr from here on: a trusted agent may close, replace or change those in sys."""
    copies = []
    _FOLDER.clear()
    with suppress(FileNotFoundError):
        _FOLDER.append(str(Path.cwd()))
    for err, stream in ((False, sys.stdout), (True, sys.stderr)):
        _OWN[err] = stream
        with suppress(AttributeError, OSError, ValueError):  # no stream, or one in memory
            copies.append(lasting(stream, os.dup(stream.fileno())))
            _OWN[err] = copies[-1]
    try:
        yield
    finally:
        _OWN.clear()
        for copy in copies:
            with suppress(OSError):  # of a full disk, which was told
                copy.close()


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
    """The help of a command, and of those below it, shows what is typed, and no types of what takes no value; on a
    narrow terminal it has no boxes, which would cut its words off: each option stands in a line of its own, and is
    explained below.
    """
    for one in getattr(command, "commands", {}).values():
        fit_help(one)
    _show_what_is_typed(command)
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


def _show_what_is_typed(command: Any) -> None:
    """Newer versions of typer write `{AGENT...}...` for an argument, and `--force <bool>` for a flag."""
    help_option = command.get_help_option(command.context_class(command, help_option_names=list(HELP_OPTIONS)))
    for parameter in (*command.params, help_option):
        if parameter.param_type_name == "argument":
            typed = parameter.metavar or parameter.name.upper()
            usage = [typed if parameter.required else f"[{typed}]"]
            parameter.get_usage_pieces = lambda _, usage=usage: usage
            parameter.display_type_rich = lambda **_: None
        elif parameter.is_flag:
            parameter.metavar = ""
