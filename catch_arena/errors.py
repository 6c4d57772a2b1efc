"""Exceptions that Catch Arena raises, and helpers for their messages.

Each message names the field, the requirement and the value.
"""

from collections.abc import Iterable
from difflib import get_close_matches


class CatchArenaError(Exception):
    """Base class of all errors that Catch Arena raises on purpose."""


class ConfigError(CatchArenaError, ValueError):
    """An invalid setting, scenario or option."""


class ActionError(CatchArenaError, ValueError):
    """An invalid action, catch request or seat; the arena is as it was before the call."""


class EpisodeError(CatchArenaError, RuntimeError):
    """A call at the wrong time: a step before the first reset or after the end."""


class ReplayError(CatchArenaError):
    """A replay file that cannot be read, or that does not play as it was recorded."""


class AgentError(CatchArenaError):
    """An agent that cannot be found, loaded or run."""


class MatchFailedError(CatchArenaError):
    """A match that failed through no fault of an agent: its result does not count, and it may be played again."""


class StoreError(CatchArenaError):
    """A tournament's store that cannot be used."""


class DamagedStoreError(StoreError):
    """A tournament's store with values that no command has written."""


class OtherTournamentError(StoreError):
    """A tournament's store that holds another tournament."""


class OutputError(CatchArenaError):
    """A result that could not be written; no partly written file remains."""


class BusError(CatchArenaError):
    """A ROS 2 bus that cannot be reached, or on which a request cannot be answered."""


def require_type(name: str, value: object, kind: type, made_by: str) -> None:
    """Raise ConfigError unless a value has a type; `made_by` is a call that returns such an object, for the message."""
    if not isinstance(value, kind):
        article = "an" if kind.__name__[0] in "AEIOU" else "a"
        raise ConfigError(f"{name} must be {article} {kind.__name__}, such as {made_by} returns, got {value!r}")


def suggest(name: object, known: Iterable[str]) -> str:
    """Return the end of an «unknown name» message: the nearest known names, or all of them if none is near."""
    choices = sorted(known)
    near = get_close_matches(str(name), choices, n=3, cutoff=0.6)
    return f"did you mean {' or '.join(near)}?" if near else f"known: {', '.join(choices)}"


def install_hint(extra: str) -> str:
    """Return the end of a «not installed» message: the command that installs this extra."""
    return f"pip install '.[{extra}]' in the clone of Catch Arena"


def reason(error: BaseException) -> str:
    """Return an exception's type and text in one line of at most 200 characters."""
    try:
        text = " ".join(str(error).split())
    except Exception:  # noqa: BLE001 - the `__str__` of foreign exceptions may raise anything
        text = "its message cannot be read"
    return f"{type(error).__name__}: {text}"[:200] if text else type(error).__name__
