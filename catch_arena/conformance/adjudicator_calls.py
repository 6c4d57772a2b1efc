"""Calls of the code under test, and its answers, read and checked: every fault becomes a `Difference`."""

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
from catch_arena.plain import whole_number
from catch_arena.text import counted, printable, shortened
from catch_arena.verdicts import Ruling, Verdict

_EVIDENCE: Final = ("distance_um", "winner")
_FIELDS: Final = ("verdict", "hunter", "target", *_EVIDENCE)
_LARGEST: Final = 2**64
"""The largest whole number in an answer: larger ones mean nothing here, and Python refuses to print the longest."""
_AGAIN_S: Final = 1.0
"""Time after which code that swallows the interruption is interrupted again [s]."""
KINDS: Final = ("winner", "granted", "refused", "verdict", "evidence")
"""Kinds of failures: another hunter is granted the target; only too much is granted; too little; only verdicts differ;
only distances or winners do.
"""
OF_GRANTS: Final = KINDS[:3]
"""Kinds in which other requests are granted."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One expected value, and the value that came in its place."""

    subject: str
    expected: str
    got: str
    kind: str = field(default="", kw_only=True)
    """One of KINDS, for this request alone; empty if the difference is not about a ruling."""

    def __str__(self) -> str:
        return f"{self.subject}: expected {self.expected}; got {self.got}"


@dataclass(frozen=True, slots=True)
class NoRuling(Difference):
    """An error, or an answer that cannot be read, in place of a ruling."""

    looks_like: str
    """The error and its place, or what is wrong with the answer."""
    rule: str = "Every request gets exactly one verdict (R5.2)."
    """The rule that the answer breaks."""


class DiffersError(Exception):
    """An adjudicator's answer differs from the one that the case expects."""

    def __init__(self, *differences: Difference) -> None:
        super().__init__(*differences)
        self.differences = differences


@dataclass(frozen=True, slots=True)
class WrongTarget:
    """Placeholder for the target of a ruling that does not repeat the requested target."""

    shortened: str
    """The target, as `text.shortened` writes it."""


def call_adjudicator(call: str, function: Callable[..., object], *arguments: object) -> Any:
    """Return the result of a function under test, named `call`; anything that it raises becomes a DiffersError."""
    try:
        return function(*arguments)
    except DiffersError:
        raise
    except (Exception, SystemExit) as error:  # the code under test may raise anything
        location = _where(error)
        raised = f"none: it raised {printable(reason(error))}{location}"
        looks_like = f"{printable(type(error).__name__)} is raised{location}"
        raise DiffersError(NoRuling(call, "an answer", raised, looks_like)) from error


@contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """Interrupt the code in the `with` block by a TimeoutError if it takes longer than `seconds`; None sets no limit.

    Only the main thread can be interrupted, and not on Windows: elsewhere there is no limit.
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
    """Return an adjudicator's rulings on these requests, or raise DiffersError for the first that is unreadable."""
    if not isinstance(given, Iterable) or isinstance(given, str | bytes | Mapping):
        too_few, got = given is None, shortened(given)
    else:
        given = list(islice(given, len(expected) + 1))  # no more: the iterable may never end
        if len(given) == len(expected):
            return [
                _ruling(place, request, ruling)
                for place, (request, ruling) in enumerate(zip(expected, given, strict=True), start=1)
            ]
        too_few = len(given) < len(expected)
        got = f"{'' if too_few else 'at least '}{len(given)} of them"
    looks_like = "too few rulings are returned, or None" if too_few else "too many rulings are returned, or not a list"
    must = f"{counted(len(expected), 'ruling')}, one for each request, in their order"
    rule = "An answer is a list with one ruling for each request, in their order (`catch-arena docs conformance`)."
    raise DiffersError(NoRuling("the answer", must, got, looks_like, rule))


def describe_request(place: int, request: ExpectedRuling) -> str:
    """Return a description of one request: its place, its hunter and its target."""
    return f"request {place}, hunter {request.hunter} asks for {shortened(request.target)}"


def _where(error: BaseException) -> str:
    """Return the file and line in which the code under test raised or was interrupted; empty if it was not reached."""
    own = Path(__file__).parent
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if Path(frame.filename).parent != own:
            return printable(f" ({Path(frame.filename).name}, line {frame.lineno})")
    return ""


def _ruling(place: int, expected: ExpectedRuling, given: object) -> Ruling:
    """Return the ruling read from an object's attributes, a mapping's keys, or a sequence in the order of _FIELDS."""

    def wrong(field: str, must: str, value: object) -> DiffersError:
        subject = f"{describe_request(place, expected)}: {field}"
        return DiffersError(NoRuling(subject, must, shortened(value), f"{field} cannot be read", f"It must be {must}."))

    fields = _fields(given)
    if not {"verdict", "hunter", "target"} <= fields.keys():
        raise wrong(
            "the ruling", "an object with verdict, hunter and target, and optionally distance_um and winner", given
        )
    verdict = _verdict(fields["verdict"])
    if verdict is None:
        raise wrong("verdict", f"one of {', '.join(Verdict.__members__)}", fields["verdict"])
    hunter = _whole(fields["hunter"])
    if hunter is None:
        raise wrong("hunter", "a whole number", fields["hunter"])
    evidence = {field: _whole(fields.get(field)) for field in _EVIDENCE}
    for name, value in evidence.items():
        if value is None and fields.get(name) is not None:
            raise wrong(name, "a whole number or None", fields[name])
    target = fields["target"]
    repeated = expected.target if _repeats(expected.target, target) else WrongTarget(shortened(target))
    return Ruling(verdict, hunter, repeated, evidence["distance_um"], evidence["winner"])


def _fields(given: object) -> dict[str, object]:
    if hasattr(given, "verdict"):
        return {name: getattr(given, name) for name in _FIELDS if hasattr(given, name)}
    if isinstance(given, Mapping):
        return {name: given[name] for name in _FIELDS if name in given}
    # the step may follow as one more value; it is ignored, since the case fixes it
    if isinstance(given, Sequence) and not isinstance(given, str | bytes) and len(given) <= len(_FIELDS) + 1:
        return dict(zip(_FIELDS, given, strict=False))
    return {}


def _verdict(value: object) -> Verdict | None:
    if isinstance(value, str):
        return Verdict.__members__.get(value)
    number = _whole(value)
    return Verdict(number) if number in set(Verdict) else None


def _whole(value: object) -> int | None:
    number = whole_number(value)
    return number if number is not None and abs(number) <= _LARGEST else None


def _repeats(requested: object, target: object) -> bool:
    """Return whether a ruling's target is the requested one.

    Targets that are not strings are compared by their `repr`, because NaN does not equal itself.
    """
    if isinstance(requested, str):
        return isinstance(target, str) and requested == target
    return repr(requested) == repr(target)
