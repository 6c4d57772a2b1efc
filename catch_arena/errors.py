"""Every error that Catch Arena raises on purpose, and how it words them.

Each message names the field, the requirement and the value.
"""

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path


class CatchArenaError(Exception):
    """The base of all errors below: catch this one to catch them all."""

    hint = ""
    """What to do, in one line, if the message does not say it."""


class ConfigError(CatchArenaError, ValueError):
    """A setting, a scenario or an option that cannot be."""


class ActionError(CatchArenaError, ValueError):
    """An action, a catch request or a seat that no rule can judge; the arena is as it was before the call."""


class EpisodeError(CatchArenaError, RuntimeError):
    """A call at the wrong time: a step before the first reset or after the end."""


class ReplayError(CatchArenaError):
    """A replay file that cannot be read, or that does not play as it was recorded."""


class AgentError(CatchArenaError):
    """An agent that cannot be found, loaded or run."""


class NoContest(CatchArenaError):  # noqa: N818 - the word of the sport
    """A match that failed on our side: no agent is to blame, nothing counts, and it may be played again."""


class StoreError(CatchArenaError):
    """A tournament's store that cannot be used."""


class OtherTournamentError(StoreError):
    """A tournament's store that holds another tournament.

    Args:
        message: where, and what differs.
        folder: the one that holds it.
    """

    def __init__(self, message: str, folder: Path) -> None:
        super().__init__(message)
        self.folder = folder


class OutputError(CatchArenaError):
    """A result that could not be written; nothing half-written is left behind."""


class BusError(CatchArenaError):
    """A ROS 2 bus that cannot be reached, or on which somebody cannot be answered.

    Args:
        message: what is wrong.
        hint: what to do, if the message does not say it.
    """

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.hint = hint


def require_type(name: str, value: object, kind: type, made_by: str) -> None:
    """Require of an argument that it has a type.

    Args:
        name: the argument's.
        value: what was given.
        kind: the type.
        made_by: a call that returns one.

    Raises:
        ConfigError: for another type.
    """
    if not isinstance(value, kind):
        article = "an" if kind.__name__[0] in "AEIOU" else "a"
        raise ConfigError(f"{name} must be {article} {kind.__name__}, as of {made_by}, got {value!r}")


def suggest(name: object, known: Iterable[str]) -> str:
    """The tail of an «unknown name» message: the nearest right names, or all of them where none is near."""
    choices = sorted(known)
    return did_you_mean(name, choices) or f"known: {', '.join(choices)}"


def did_you_mean(name: object, known: Sequence[str]) -> str:
    """The nearest right names as a question; nothing where none is near."""
    near = get_close_matches(str(name), known, n=3, cutoff=0.6)
    return f"did you mean {' or '.join(near)}?" if near else ""


def install_hint(extra: str) -> str:
    """The tail of a message that something is not installed: the README's way to install, with this extra."""
    return f"pip install '.[{extra}]' in the clone of Catch Arena"


def reason(error: BaseException) -> str:
    """An exception in one line of at most 200 characters."""
    try:
        text = " ".join(str(error).split())
    except Exception:  # noqa: BLE001 - a stranger's exception may raise anything
        text = "its own text cannot be had"
    return f"{type(error).__name__}: {text}"[:200] if text else type(error).__name__
