"""Why cases failed: which of the known mistakes the answers look like, and what the others have in common."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, cast

from catch_arena.conformance.answers import RaisedError, UnreadableAnswer, WrongTarget
from catch_arena.conformance.arena_runner import WrongReading
from catch_arena.conformance.cases import ArbiterCase, ArenaCase, ExpectedRuling
from catch_arena.conformance.comparison import Strictness, WrongRuling
from catch_arena.conformance.mistakes.known_mistakes import EVIDENCE, meaning
from catch_arena.conformance.mistakes.search import Search
from catch_arena.conformance.results import Failure, Result
from catch_arena.verdicts import Ruling, Verdict


class _Kind(NamedTuple):
    """What failures have in common; the fields are those of a Diagnosis."""

    looks_like: str
    rule: str
    known: bool = False
    conceptual: bool = True


_LOT: Final = _Kind(
    "a lot is drawn wrongly",
    "A lot has one winner, the same in every order of requests and without the losers, and is fair to the tied (R5.5).",
)


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """Failures that look like one mistake."""

    looks_like: str
    rule: str
    """What the rulebook says."""
    failures: tuple[Failure, ...]
    """The plainest first; last those for which others of the diagnoses are needed too."""
    known: bool
    """An arbiter with this mistake answers exactly so; else only the answers are alike."""
    conceptual: bool
    """An idea is wrong, as who wins or what is within reach; else as of `known_mistakes.Mistake`."""
    shared: int = 0
    """How many of the failures need others too."""


def diagnose(results: Sequence[Result], strictness: Strictness) -> tuple[Diagnosis, ...]:
    """Each failure in one diagnosis, a known mistake or what it has in common with others; wrong ideas first, and of
    those the large ones.
    """
    search = Search(results, strictness)
    found = search.mistakes()
    groups: dict[_Kind, list[tuple[bool, Failure]]] = {}
    for result in results:
        if result.failure is None:
            continue
        mistakes = search.behind(found, result)
        if mistakes:
            kind = _Kind(mistakes[-1].looks_like, mistakes[-1].rule, known=True, conceptual=mistakes[-1].conceptual)
        else:
            kind = _LOT if search.has_inconsistent_lots(result) else _alike(result.failure, strictness)
        groups.setdefault(kind, []).append((len(mistakes) > 1, result.failure))
    diagnoses = []
    for kind, members in groups.items():
        members.sort(key=lambda one: (one[0], _difficulty(one[1])))
        failures = tuple(failure for _, failure in members)
        diagnoses.append(Diagnosis(**kind._asdict(), failures=failures, shared=sum(shared for shared, _ in members)))
    return tuple(sorted(diagnoses, key=lambda one: (not one.conceptual, -len(one.failures), not one.known)))


def _difficulty(failure: Failure) -> tuple[bool, bool, int]:
    """What is easily understood comes first: as it stands, with some requests but few, and few hunters."""
    case, changed = failure.case, failure.how not in {"", "in an arena"}
    if isinstance(case, ArbiterCase):
        return changed, not case.expected, len(case.hunters) + len(case.expected)
    return changed, False, len(case.play)


def _alike(failure: Failure, strictness: Strictness) -> _Kind:
    """What a failure has in common with others that no known mistake explains."""
    difference = failure.main_difference
    if isinstance(difference, WrongRuling):
        if strictness.success_only:
            right, got = cast(Verdict, difference.right.verdict), difference.given.success
            looks_like = f"{'granted' if got else 'refused'} where {right.name} is right ({failure.case.clauses[0]})"
            return _Kind(looks_like, meaning(right), conceptual=False)
        return _Kind(*_ruling_mistake(difference.right, difference.given, failure.case.clauses[0]), conceptual=False)
    if isinstance(difference, WrongReading):
        return _Kind(*_reading_mistake(difference, failure.case))
    if isinstance(difference, RaisedError):
        return _Kind(
            f"{difference.error} is raised{difference.where}", "Every request gets exactly one verdict (R5.2)."
        )
    if isinstance(difference, UnreadableAnswer):
        return _Kind(difference.looks_like, difference.rule)
    return _LOT


def _ruling_mistake(right: ExpectedRuling, given: Ruling, clause: str) -> tuple[str, str]:
    """One ruling where another was expected, and the rule."""
    expected, got = cast(Verdict, right.verdict), given.verdict  # whom a lot draws is known by now
    if expected is not got:
        return f"{got.name} where {expected.name} is right ({clause})", meaning(expected)
    wrong = {
        "hunter": right.hunter != given.hunter,
        "target": isinstance(given.target, WrongTarget),
        "distance": right.distance_um != given.distance_um,
        "winner": right.winner != given.winner,
    }
    other = " and ".join(field for field in wrong if wrong[field])
    return f"{expected.name} with a wrong {other} ({clause})", EVIDENCE


class _ReadingMistake(NamedTuple):
    """A wrong reading of an arena in words, and the clause that says so."""

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


def _sees_fewer(right: Any, found: Any) -> bool:
    return any(set(a) > set(b) for a, b in zip(right, found, strict=True))


def _sees_more(right: Any, found: Any) -> bool:
    return any(set(a) < set(b) for a, b in zip(right, found, strict=True))


def _is_out_elsewhere(right: Any, found: Any) -> bool:
    return [number == 0 for number in right] != [number == 0 for number in found]


_SEEN: Final = (
    "Seen is what is nearer than the radius and within the cone, or within one's own reach; the nearest first (R7.5)."
)
_REFUSED_KILL: Final = _ReadingMistake(
    "alive", _fewer, "a target leaves although its kill was refused", "Where a kill is refused the target stays (R5.7)."
)
_READING_MISTAKES: Final = (
    _ReadingMistake(
        "alive",
        _shuffled,
        "the alive targets change their order",
        "They keep their spawning order, whichever of them is caught (R8.2).",
    ),
    _ReadingMistake("alive", _fewer, "too few targets are alive", "What is not caught or killed stays (R5.8, R8.2)."),
    _ReadingMistake(
        "alive", _more, "too many targets are alive", "At most max_targets are, and what is caught leaves (R3.5, R5.8)."
    ),
    _ReadingMistake(
        "alive", _lower, "spawn numbers are used again", "A number is never used again in an episode (R3.4)."
    ),
    _ReadingMistake(
        "alive",
        _higher,
        "spawn numbers are left out",
        "A firing that is skipped uses up no number, and an episode begins with 1 (R3.4 to R3.6).",
    ),
    _ReadingMistake(
        "appeared_ms", _fewer, "targets do not appear", "The spawn timer fires once in every period (R3.1)."
    ),
    _ReadingMistake("appeared_ms", _more, "too many targets appear", "At most max_targets are alive (R3.5)."),
    _ReadingMistake(
        "appeared_ms",
        _other,
        "targets appear at other times",
        "The timer's period is floor(1000 / frequency + 0.5) ms, its first firing one period after reset (R3.1).",
    ),
    _ReadingMistake("scores", _lower, "a catch is not credited", "A score is the number of granted catches (R6.1)."),
    _ReadingMistake("scores", _higher, "a score counts too much", "A score is the number of granted catches (R6.1)."),
    _ReadingMistake(
        "team_scores", _other, "a team's score is another", "It is the sum of its hunters' scores (R11.1)."
    ),
    _ReadingMistake(
        "times_caught",
        _other,
        "prey's catches are counted otherwise",
        "Each catch of its target counts (R12.3, R12.5).",
    ),
    _ReadingMistake(
        "prey",
        _is_out_elsewhere,
        "prey is out, or back, at another time",
        "It returns when its time is up and there is room, after the firings (R12.3).",
    ),
    _ReadingMistake(
        "prey",
        _other,
        "prey plays other targets",
        "Prey i begins with number i + 1, and returns under the next one, by index (R12.1, R12.3).",
    ),
    _ReadingMistake(
        "ended",
        _other,
        "the match ends at another time, or in another way",
        "It is truncated at its time limit, or terminated when nothing is alive and nothing will appear (R1.5).",
    ),
    *(
        _ReadingMistake(word, fits, looks_like, _SEEN)
        for word in ("seen", "rivals_seen")
        for fits, looks_like in (
            (_sees_fewer, "hunters do not see all that they should"),
            (_sees_more, "hunters see what they should not"),
            (_other, "hunters see other things, or in another order"),
        )
    ),
    _ReadingMistake(
        "time_ms", _other, "the clock goes otherwise", "It counts milliseconds since reset (R1.1 to R1.3)."
    ),
    _ReadingMistake(
        "spawned", _other, "appearances are counted otherwise", "`spawned` is how many targets appeared (R3.5, R3.6)."
    ),
    _ReadingMistake(
        "skipped_full",
        _other,
        "firings into a full arena are counted otherwise",
        "A firing that finds the arena full is skipped and counted (R3.5).",
    ),
    _ReadingMistake(
        "skipped_down",
        _other,
        "firings while the spawn service is down are counted otherwise",
        "Such a firing is skipped and uses up no number (R3.6).",
    ),
    _ReadingMistake(
        "refused",
        _other,
        "refused spawns are counted otherwise",
        "A spawn that is refused uses up its number, and no target appears (R3.6).",
    ),
)


def _reading_mistake(reading: WrongReading, case: ArbiterCase | ArenaCase) -> tuple[str, str]:
    """What a wrong reading looks like, and what the rulebook says."""
    refused = case.circumstances["kill_refused"] if isinstance(case, ArbiterCase) else case.settings.get("kill_refused")
    for row in (_REFUSED_KILL, *_READING_MISTAKES) if refused else _READING_MISTAKES:
        try:
            fits = row.word == reading.about and row.fits(reading.right, reading.found)
        except (TypeError, ValueError):  # whatever read() gave
            continue
        if fits:
            return row.looks_like, row.rule
    return f"{reading.about} cannot be read", "`catch-arena docs conformance` says what read() returns."
