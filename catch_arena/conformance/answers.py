"""A stranger's code is called, and its answer read: whatever is wrong with it becomes a difference in words."""

import operator
import signal
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from threading import current_thread, main_thread
from typing import Any, Final

from catch_arena.conformance.cases import ExpectedRuling
from catch_arena.errors import reason
from catch_arena.text import in_short, printable
from catch_arena.verdicts import Ruling, Verdict

_EVIDENCE: Final = ("distance_um", "winner")
_FIELDS: Final = ("verdict", "hunter", "target", *_EVIDENCE)
_LARGEST: Final = 2**64
"""Of whole numbers: longer ones mean nothing here, and Python refuses to write the longest."""
_AGAIN_S: Final = 1.0
"""Code that swallows the interruption is interrupted again."""
KINDS: Final = ("success", "verdict", "evidence")
"""Kinds of differences between rulings, the strongest first: in the grant, the verdict, the distance or the winner."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One thing that was expected, and what came in its place."""

    about: str
    expected: str
    got: str
    kind: str = field(default="", kw_only=True)
    """One of KINDS; empty if it is not about a ruling."""

    def __str__(self) -> str:
        return f"{self.about}: expected {self.expected}; got {self.got}"


@dataclass(frozen=True, slots=True)
class UnreadableAnswer(Difference):
    """An answer, or a part of it, that is no ruling whatever it says."""

    looks_like: str
    rule: str
    """What docs/conformance.md says."""


@dataclass(frozen=True, slots=True)
class RaisedError(Difference):
    """An error in place of an answer."""

    error: str
    """Its class."""
    where: str
    """« (file, line)» of a stranger's code, or nothing."""


class DiffersError(Exception):
    """An adjudicator's answer is not what the case expects."""

    def __init__(self, *differences: Difference) -> None:
        super().__init__(*differences)
        self.differences = differences


@dataclass(frozen=True, slots=True)
class WrongTarget:
    """Stands for the target of a ruling that does not repeat what was asked for."""

    in_short: str
    """The target, as `in_short` writes it."""


def call_adjudicator(what: str, function: Callable[..., object], *arguments: object) -> Any:
    """What a stranger's code returns; `what` names the call.

    Raises:
        DiffersError: where it raises anything.
    """
    try:
        return function(*arguments)
    except DiffersError:
        raise
    except (Exception, SystemExit) as error:  # a stranger's code may raise anything
        where = _where(error)
        raised = f"none: it raised {printable(reason(error))}{where}"
        raise DiffersError(RaisedError(what, "an answer", raised, printable(type(error).__name__), where)) from error


@contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """A stranger's code that takes longer is interrupted where it stands, by a TimeoutError.

    Only the main thread can be interrupted, and not on Windows: elsewhere it may take as long as it likes.
    """
    if seconds is None or not hasattr(signal, "setitimer") or current_thread() is not main_thread():
        yield
        return

    def interrupt(*_: object) -> None:
        raise TimeoutError(f"no answer within {seconds:g} s")

    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, seconds, _AGAIN_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def read_rulings(given: object, expected: Sequence[ExpectedRuling]) -> list[Ruling]:
    """What an adjudicator answers to these requests; the target of a ruling that names another one is a WrongTarget.

    Raises:
        DiffersError: for the first thing that cannot be read.
    """
    if not isinstance(given, Iterable) or isinstance(given, str | bytes | Mapping):
        too_few, got = given is None, in_short(given)
    else:
        given = list(islice(given, len(expected) + 1))  # no more: it may never end
        if len(given) == len(expected):
            return [
                _ruling(place, one, ruling)
                for place, (one, ruling) in enumerate(zip(expected, given, strict=True), start=1)
            ]
        too_few = len(given) < len(expected)
        got = f"{'' if too_few else 'at least '}{len(given)} of them"
    looks_like = "None or too few rulings are returned" if too_few else "too many rulings, or no list, are returned"
    must = f"{counted(len(expected), 'ruling')}, one for each request, in their order"
    rule = "An answer is a list with one ruling for each request, in their order (`catch-arena docs conformance`)."
    raise DiffersError(UnreadableAnswer("the answer", must, got, looks_like, rule))


def counted(number: int, thing: str) -> str:
    """So many of something, whose plural ends in s."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def request_in_words(place: int, one: ExpectedRuling) -> str:
    """Who asks for what."""
    return f"request {place}, hunter {one.hunter} asks for {in_short(one.target)}"


def _where(error: BaseException) -> str:
    """The file and line in which a stranger's code raised an error or was interrupted, if it was reached at all."""
    own = Path(__file__).parent
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if Path(frame.filename).parent != own:
            return printable(f" ({Path(frame.filename).name}, line {frame.lineno})")
    return ""


def _ruling(place: int, expected: ExpectedRuling, given: object) -> Ruling:
    """A ruling of an object with its attributes, of a mapping with its keys, or of a sequence in its order."""

    def wrong(field: str, must: str, value: object) -> DiffersError:
        about = f"{request_in_words(place, expected)}: {field}"
        return DiffersError(
            UnreadableAnswer(about, must, in_short(value), f"{field} cannot be read", f"It must be {must}.")
        )

    fields = _fields(given)
    if not {"verdict", "hunter", "target"} <= fields.keys():
        raise wrong("the ruling", "verdict, hunter, target, and perhaps distance_um and winner", given)
    verdict = _verdict(fields["verdict"])
    if verdict is None:
        raise wrong("verdict", f"one of {', '.join(Verdict.__members__)}", fields["verdict"])
    hunter = _whole(fields["hunter"])
    if hunter is None:
        raise wrong("hunter", "a whole number", fields["hunter"])
    evidence = {field: _whole(fields.get(field)) for field in _EVIDENCE}
    for word, value in evidence.items():
        if value is None and fields.get(word) is not None:
            raise wrong(word, "a whole number or None", fields[word])
    target = fields["target"]
    repeated = expected.target if _repeats(expected.target, target) else WrongTarget(in_short(target))
    return Ruling(verdict, hunter, repeated, evidence["distance_um"], evidence["winner"])


def _fields(given: object) -> dict[str, object]:
    if hasattr(given, "verdict"):
        return {name: getattr(given, name) for name in _FIELDS if hasattr(given, name)}
    if isinstance(given, Mapping):
        return {name: given[name] for name in _FIELDS if name in given}
    # one more may follow, the step, which is the case's own
    if isinstance(given, Sequence) and not isinstance(given, str | bytes) and len(given) <= len(_FIELDS) + 1:
        return dict(zip(_FIELDS, given, strict=False))
    return {}


def _verdict(value: object) -> Verdict | None:
    if isinstance(value, str):
        return Verdict.__members__.get(value)
    number = _whole(value)
    return Verdict(number) if number in set(Verdict) else None


def _whole(value: object) -> int | None:
    if isinstance(value, bool):
        return None
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        return None
    return number if abs(number) <= _LARGEST else None


def _repeats(asked: object, target: object) -> bool:
    """Whether a ruling's target is what was asked for; by its looks, where that is no string: NaN does not equal
    itself.
    """
    if isinstance(asked, str):
        return isinstance(target, str) and asked == target
    return repr(asked) == repr(target)
