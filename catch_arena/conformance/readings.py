"""What stands in an arena and should not: in words, with the clause that says so."""

from collections.abc import Callable
from typing import Any, Final, NamedTuple

from catch_arena.conformance.arenas import OtherReading
from catch_arena.conformance.cases import ArbiterCase, WorldCase


class _Row(NamedTuple):
    word: str
    """One of READINGS."""
    fits: Callable[[Any, Any], bool]
    """From what is right, and what was found."""
    looks_like: str
    rule: str


def _fewer(right: Any, found: Any) -> bool:
    return len(found) < len(right)


def _more(right: Any, found: Any) -> bool:
    return len(found) > len(right)


def _lower(right: Any, found: Any) -> bool:
    return len(found) == len(right) and any(a < b for a, b in zip(found, right, strict=True))


def _higher(right: Any, found: Any) -> bool:
    return len(found) == len(right) and any(a > b for a, b in zip(found, right, strict=True))


def _shuffled(right: Any, found: Any) -> bool:
    return sorted(found) == sorted(right)


def _other(right: Any, found: Any) -> bool:
    return bool(found != right)


_REFUSED: Final = _Row(
    "alive", _fewer, "a target leaves although its kill was refused", "Where a kill is refused the target stays (R5.7)."
)
_ROWS: Final = (
    _Row(
        "alive",
        _shuffled,
        "the alive targets change their order",
        "They keep their spawning order, whichever of them is caught (R8.2).",
    ),
    _Row("alive", _fewer, "too few targets are alive", "What is not caught or killed stays (R5.8, R8.2)."),
    _Row(
        "alive", _more, "too many targets are alive", "At most max_targets are, and what is caught leaves (R3.5, R5.8)."
    ),
    _Row("alive", _lower, "spawn numbers are used again", "A number is never used again in an episode (R3.4)."),
    _Row(
        "alive",
        _higher,
        "spawn numbers are left out",
        "A firing that is skipped uses up no number, and an episode begins with 1 (R3.4 to R3.6).",
    ),
    _Row("appeared_ms", _fewer, "targets do not appear", "The spawn timer fires once in every period (R3.1)."),
    _Row("appeared_ms", _more, "too many targets appear", "At most max_targets are alive (R3.5)."),
    _Row(
        "appeared_ms",
        _other,
        "targets appear at other times",
        "The timer's period is floor(1000 / frequency + 0.5) ms, its first firing one period after reset (R3.1).",
    ),
    _Row("scores", _lower, "a catch is not credited", "A score is the number of granted catches (R6.1)."),
    _Row("scores", _higher, "a score counts too much", "A score is the number of granted catches (R6.1)."),
    _Row(
        "ended",
        _other,
        "the match ends at another time, or in another way",
        "It is truncated at its time limit, or terminated with the last target of its budget (R1.5).",
    ),
    _Row("time_ms", _other, "the clock goes otherwise", "It counts milliseconds since reset (R1.1 to R1.3)."),
    _Row(
        "spawned", _other, "appearances are counted otherwise", "`spawned` is how many targets appeared (R3.5, R3.6)."
    ),
    _Row(
        "skipped_full",
        _other,
        "firings into a full arena are counted otherwise",
        "A firing that finds the arena full is skipped and counted (R3.5).",
    ),
    _Row(
        "skipped_down",
        _other,
        "firings while the spawn service is down are counted otherwise",
        "Such a firing is skipped and uses up no number (R3.6).",
    ),
    _Row(
        "refused",
        _other,
        "refused spawns are counted otherwise",
        "A spawn that is refused uses up its number, and no target appears (R3.6).",
    ),
)


def reading_mistake(reading: OtherReading, case: ArbiterCase | WorldCase) -> tuple[str, str]:
    """What a wrong reading looks like, and what the rulebook says."""
    refused = case.circumstances["kill_refused"] if isinstance(case, ArbiterCase) else case.settings.get("kill_refused")
    for row in (_REFUSED, *_ROWS) if refused else _ROWS:
        try:
            fits = row.word == reading.about and row.fits(reading.right, reading.found)
        except (TypeError, ValueError):  # whatever read() gave
            continue
        if fits:
            return row.looks_like, row.rule
    return f"{reading.about} cannot be read", "docs/conformance.md says what read() returns."
