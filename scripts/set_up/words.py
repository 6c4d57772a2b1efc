"""What set-up says, and what the failures of others mean."""

import re
import shutil
import sys
from pathlib import Path
from typing import NoReturn

TOLD_EVERY_S = 5.0
"""[s] between two lines of a step that takes long."""

AGAIN = "The same command goes on from here."

_CUT = r"Wheel '(?P<what>.*)' located at .* is invalid|DO NOT MATCH THE HASHES|IncompleteRead|incomplete-download|"
_CUT += "ConnectionReset|ProtocolError"
_NO_NETWORK = (
    "NewConnectionError|NameResolutionError|ConnectTimeout|ReadTimeout|Temporary failure in name resolution|"
    "Network is unreachable|Connection refused|ProxyError|SSLError"
)
_NOT_LISTED = r"\(from versions: none\)(?s:.*)No matching distribution found for (?P<what>.*)"
_NONE_FITS = r"No matching distribution found for (?P<what>.*)"
_CAUSES = (
    (r"No space left on device|Errno 28\b|Disk quota exceeded|Errno 122\b", "the disk is full: {space}"),
    (_CUT, "what was downloaded {of_what}is damaged; did the connection break off?"),
    (_NO_NETWORK, "the package index cannot be reached; is there a network? Asked: {indexes}"),
    (
        _NOT_LISTED,
        "the package index listed no {what} for this Python; is a login page before it? Asked: {indexes}",
    ),
    (_NONE_FITS, "the package index has no {what} for this Python. Asked: {indexes}"),
    (r"Permission denied|Errno 13\b", "a folder cannot be written: {last}"),
)
"""What Python and pip say, and what it means; the first that fits is told."""


def say(line: str) -> None:
    """One line, at once, whoever reads it."""
    print(line, flush=True)


def fail(line: str) -> NoReturn:
    """One line or a few that say what to do; `make` adds its own."""
    print(line, file=sys.stderr, flush=True)
    sys.exit(1)


def counted(number: int, noun: str) -> str:
    """`1 package`, `2 packages`."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def cause(said: str, *folders: Path) -> str | None:
    """What a failure means; None where that is not known. `folders` are those that were written to."""
    for pattern, words in _CAUSES:
        if found := re.search(pattern, said):
            what = found.groupdict().get("what")
            return words.format(
                what=what,
                of_what=f"of {what} " if what else "",
                last=last_line(said),
                space=space(*folders),
                indexes=_indexes(said),
            )
    return None


def space(*folders: Path) -> str:
    """How much is left where these folders are."""
    return ", ".join(f"{folder} has {shutil.disk_usage(folder).free / 1e6:.0f} MB left" for folder in folders)


def last_line(said: str) -> str:
    """The last error of pip, or else the last line."""
    lines = [line for line in said.splitlines() if line.strip()] or ["no reason was given"]
    return next((line for line in reversed(lines) if line.startswith("ERROR")), lines[-1]).strip().rstrip(".")


def _indexes(said: str) -> str:
    """Those that pip asked; it hides the passwords in them, and names none where there is but the usual one."""
    asked = re.search(r"Looking in (?:indexes|links): (.*)", said)
    return asked[1] if asked else "PyPI"
