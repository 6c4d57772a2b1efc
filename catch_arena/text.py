r"""Safe forms of foreign text, such as agents' names, output and errors, for terminals, files and pages.

Unprintable characters (control characters, lone surrogates, marks that change the direction of writing) become
Python's escapes: `\x1b`, `\ud800`, `\u202e`. This is done once, when such a text is received.
"""

import re
import reprlib
import unicodedata
from typing import Final

LONGEST_NAME: Final = 100
"""Largest length of an entrant's name [characters]."""
LONGEST_LINE: Final = 300
"""Largest length of a failure's description [characters]."""
_SOURCE: Final = re.compile(r"^([| ]*  File .*, line \d+.*)(?:\n[| ]*    .*)+", re.MULTILINE)
"""Pattern of a place in a traceback, and of the lines of source and marks after it."""
_LONGEST_LOG_LINE: Final = 200
"""Largest length of a line that is shown of a log [characters]."""
_FOLDERS: Final = re.compile(
    r"""(?<=['"])/(?:[^/'"]+/+)+|(?<![\w<.~/])~?/(?:[^\s/'"<>]+/+)+|\b[A-Za-z]:[\\/](?:[^\s\\/'"<>]+[\\/]+)*"""
)
"""Folders of absolute paths: in quotes (spaces allowed), without quotes, or of Windows."""


def composed(text: str) -> str:
    """Return the text in Unicode's composed form (NFC), so that names that look the same are the same.

    Some systems write file names decomposed, and the fonts that names are drawn in have composed letters only.
    """
    return unicodedata.normalize("NFC", text)


def printable(text: str) -> str:
    """Return the text in one line, with escapes for unprintable characters, including line ends."""
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in text)


def printable_lines(text: str) -> str:
    """Return the text with escapes for unprintable characters, except line ends and tabs."""
    return "\n".join("\t".join(map(printable, line.split("\t"))) for line in text.split("\n"))


def one_line(text: str) -> str:
    """Return the text's words in one line of at most LONGEST_LINE characters."""
    return printable(" ".join(text[: 8 * LONGEST_LINE].split()))[:LONGEST_LINE]


def last_lines(log: str, count: int = 40) -> str:
    """Return the last lines of a log, whole, except that a very long line is cut at its end."""
    lines = log.rstrip().splitlines()[-count:]
    return "\n".join(line if len(line) <= _LONGEST_LOG_LINE else f"{line[:_LONGEST_LOG_LINE]} …" for line in lines)


def shortened(value: object) -> str:
    """Return the shortened `repr` of any value in one line; the name of its type in <> if `repr` fails."""
    try:
        return printable(" ".join(reprlib.repr(value).split()))
    except Exception:  # noqa: BLE001 - foreign values may raise anything, and a number may be too long for `repr`
        return f"<{printable(type(value).__name__)}>"


def with_type(value: object) -> str:
    """Return a value's shortened `repr` with the name of its type, for errors about types: `'4' (str)`."""
    return "None" if value is None else f"{shortened(value)} ({printable(type(value).__name__)})"


def name_fault(name: str) -> str | None:
    """Return an error text for an invalid entrant's name; None for a valid one."""
    if name and name.isprintable() and len(name) <= LONGEST_NAME:
        return None
    return f"its name must have 1 to {LONGEST_NAME} printable characters, got {name[:200]!a}"


def without_source(log: str) -> str:
    """Return a log in which tracebacks have their files and lines, but no lines of source."""
    return _SOURCE.sub(r"\1", log)


def without_folders(text: str) -> str:
    """Return the text with each absolute path replaced by the file's name."""
    return _FOLDERS.sub("", text)


def spreadsheet_cell(text: str) -> str:
    """Return the text as a cell of a CSV file; an apostrophe before a formula keeps spreadsheets from running it."""
    return f"'{text}" if text.startswith(("=", "+", "-", "@")) else text


def counted(number: int, noun: str, plural: str | None = None) -> str:
    """Return a number with its noun, whose plural ends in s if none is given: "1 case", "2 cases"."""
    return f"{number} {noun if number == 1 else plural or noun + 's'}"
