r"""Text from strangers is text: what agents are called, say and raise, as every terminal, file and page can hold it.

What cannot be printed (control characters, halves of surrogate pairs, marks that turn the direction of writing) is
shown as Python writes it: `\x1b`, `\ud800`, `\u202e`. It is done once, where such a text comes in.
"""

import re
import reprlib
import unicodedata
from typing import Final

LONGEST_NAME: Final = 100
"""Characters of an entrant's name."""
LONGEST_LINE: Final = 300
"""Characters of what is said about a failure."""
_LOOKED_AT: Final = 8 * LONGEST_LINE
_FOLDERS: Final = re.compile(
    r"""(?<=['"])/(?:[^/'"]+/+)+|(?<![\w<.~/])~?/(?:[^\s/'"<>]+/+)+|\b[A-Za-z]:[\\/](?:[^\s\\/'"<>]+[\\/]+)*"""
)
"""Of whole paths: in quotes, where they may have spaces, or not; and those of Windows."""
_FORMULA: Final = ("=", "+", "-", "@")


def composed(text: str) -> str:
    """Return the text in Unicode's composed form (NFC), so that names that look the same are the same.

    Some systems write file names decomposed, and the fonts that names are drawn in have composed letters only.
    """
    return unicodedata.normalize("NFC", text)


def printable(text: str) -> str:
    """The text in one line, with escapes for what cannot be printed, line ends among it."""
    return text if text.isprintable() else "".join(map(_letter, text))


def printable_lines(text: str) -> str:
    """The same, but that line ends and tabs stay."""
    return "\n".join("\t".join(map(printable, line.split("\t"))) for line in text.split("\n"))


def one_line(text: str) -> str:
    """The text's words in one line of at most LONGEST_LINE characters."""
    return printable(" ".join(text[:_LOOKED_AT].split()))[:LONGEST_LINE]


def in_short(value: object) -> str:
    """A value as Python writes it, in one short line, whatever it is; its kind, where it cannot be written."""
    try:
        return printable(" ".join(reprlib.repr(value).split()))
    except Exception:  # noqa: BLE001 - a stranger's value may raise anything, and a number be too long to be written
        return f"<{printable(type(value).__name__)}>"


def with_type(value: object) -> str:
    """A value in short with the name of its type, for errors about the type: `'4' (str)`."""
    return "None" if value is None else f"{in_short(value)} ({printable(type(value).__name__)})"


def name_fault(name: str) -> str | None:
    """What is wrong with an entrant's name; None where nothing is."""
    if name and name.isprintable() and len(name) <= LONGEST_NAME:
        return None
    return f"its name must be of characters that can be printed, at most {LONGEST_NAME} of them, got {name[:200]!a}"


def without_folders(text: str) -> str:
    """The text with the name alone of each file that it gives a whole path of."""
    return _FOLDERS.sub("", text)


def spreadsheet_cell(text: str) -> str:
    """The text as a cell of a CSV file, in which a spreadsheet must not find a formula: with an apostrophe, which says
    that text follows, where it begins like one.
    """
    return f"'{text}" if text.startswith(_FORMULA) else text


def _letter(letter: str) -> str:
    return letter if letter.isprintable() else ascii(letter)[1:-1]
