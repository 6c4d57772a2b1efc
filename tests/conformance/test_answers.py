"""Answers of arbiters and arenas are read in several forms, and a report says in words what is wrong with one."""

import contextlib
import dataclasses
import itertools
import re
from collections import namedtuple
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from conformance.arenas import AdjudicatorUnderTest

from catch_arena import Ruling
from catch_arena.arbitration import arbitrate
from catch_arena.errors import ConfigError
from catch_arena.testing import run_conformance

Fields = namedtuple("Fields", "target hunter verdict step winner distance_um")  # noqa: PYI024 - in an order of its own


def translated(form: Any) -> Any:
    """`arbitrate`, with each of its rulings in another form."""
    return lambda **case: [form(ruling) for ruling in arbitrate(**case)]


def as_dict(ruling: Ruling) -> dict[str, Any]:
    return dataclasses.asdict(ruling)


FORMS: dict[str, Any] = {
    "rulings": arbitrate,
    "dicts": translated(as_dict),
    "names": translated(lambda ruling: {**as_dict(ruling), "verdict": ruling.verdict.name}),
    "numbers": translated(lambda ruling: {**as_dict(ruling), "verdict": int(ruling.verdict), "note": "and more"}),
    "nothing for None": translated(
        lambda ruling: {key: one for key, one in as_dict(ruling).items() if one is not None}
    ),
    "tuples": translated(lambda ruling: tuple(as_dict(ruling).values())),
    "lists": translated(lambda ruling: list(as_dict(ruling).values())),
    "objects": translated(lambda ruling: SimpleNamespace(**as_dict(ruling))),
    "named tuples": translated(lambda ruling: Fields(**as_dict(ruling))),
    "numpy's numbers": translated(lambda ruling: (np.uint8(ruling.verdict), *list(as_dict(ruling).values())[1:])),
    "a tuple of them": lambda **case: tuple(arbitrate(**case)),
    "a generator of them": lambda **case: (ruling for ruling in arbitrate(**case)),
}


@pytest.mark.parametrize("arbiter", FORMS.values(), ids=FORMS)
def test_rulings_are_read_in_many_forms(arbiter: Any):
    report = run_conformance(arbiter, only=["basics", "ties.cross", "names"], exact_lots=True)
    assert report.passed, str(report)


def raises(**case: Any) -> Any:
    raise ValueError("no\nidea" if case["requests"] else "")


def leaves(**_: Any) -> Any:
    raise SystemExit(1)


def breaks_off(**case: Any) -> Any:
    yield from arbitrate(**case)
    raise KeyError("later")


class Unreadable:
    @property
    def verdict(self) -> str:
        raise RuntimeError("broken property")


GRANTED = ("GRANTED", 0, "a", 100_000, 0)


@pytest.mark.parametrize(
    ("arbiter", "about", "got"),
    [
        (raises, "the call", "raised ValueError: no idea"),
        (leaves, "the call", "raised SystemExit: 1"),
        (breaks_off, "the answer", "raised KeyError: 'later'"),
        (lambda hunters: hunters, "the call", "unexpected keyword argument"),
        (lambda **_: None, "the answer", "None"),
        (lambda **_: "GRANTED", "the answer", "'GRANTED'"),
        (lambda **_: [], "the answer", "0 of them"),
        (lambda **_: itertools.repeat(GRANTED), "the answer", "at least 2 of them"),
        (lambda **_: ["GRANTED"], "the ruling", "'GRANTED'"),
        (lambda **_: [(*GRANTED, 0, 7)], "the ruling", "('GRANTED'"),
        (lambda **_: [Unreadable()], "the answer", "raised RuntimeError: broken property"),
        (lambda **_: [{"verdict": "GRANTED"}], "the ruling", "{'verdict': 'GRANTED'}"),
        (lambda **_: [("granted", 0, "a", 100_000, 0)], "verdict", "'granted'"),
        (lambda **_: [(True, 0, "a", 100_000, 0)], "verdict", "True"),
        (lambda **_: [("GRANTED", "0", "a", 100_000, 0)], "hunter", "'0'"),
        (lambda **_: [("GRANTED", 0, "a", 100_000.0, 0)], "distance_um", "100000.0"),
        (lambda **_: [("GRANTED", 0, "a", 100_000, "hunter_0")], "winner", "'hunter_0'"),
        (lambda **_: [("GRANTED", 5, "a", 100_000, 0)], "request 1", "for hunter 5"),
        (lambda **_: [("GRANTED", 0, "b", 100_000, 0)], "request 1", "for target 'b'"),
        (lambda **_: [("GRANTED", 0, np.zeros(3), 100_000, 0)], "request 1", "for target array"),
        (lambda **_: [("GRANTED", 0, "a", 100_000, 5)], "request 1", "won by hunter 5"),
        (lambda **_: [("GRANTED", 0, "a", 2**70, 0)], "request 1", f"{2**70}"),
        (lambda **_: [("OUT_OF_REACH", 0, "a", 100_000, None)], "request 1", "OUT_OF_REACH, 100000 um away"),
    ],
)
def test_whatever_an_arbiter_does_wrong_is_told_in_words(arbiter: Any, about: str, got: str):
    """No traceback: a difference with what was expected, and what came."""
    report = run_conformance(arbiter, only=["basics.in-reach"])
    assert not report.passed
    (failure,) = report.failures
    (difference,) = failure.differences
    assert about in difference.subject
    assert got in difference.got
    assert difference.expected
    assert difference.got in " ".join(str(report).split())


def test_a_report_says_where_an_arbiter_raised():
    """But not where the suite called one that could not be called."""
    report = run_conformance(raises, only=["basics.in-reach"])
    assert re.search(r"raised ValueError: no idea \(test_answers.py, line \d+\)", " ".join(str(report).split()))
    assert "line" not in str(run_conformance(lambda hunters: hunters, only=["basics.in-reach"]))


def test_an_arbiter_may_change_what_it_is_given():
    """The next call gets containers of its own."""

    def destructive(**case: Any) -> list[Ruling]:
        rulings = arbitrate(**case)
        for given in case.values():
            if isinstance(given, list | dict):
                given.clear()
        return rulings

    assert run_conformance(destructive).passed


def test_an_arbiter_that_depends_on_the_order_is_told_which():
    def in_turn(**case: Any) -> list[Ruling]:
        rulings = arbitrate(**{**case, "policy": "first_come", "seed": case["requests"][0][0]})
        return [dataclasses.replace(ruling, winner=ruling.winner) for ruling in rulings]

    report = run_conformance(in_turn, only=["ties.mirrored-left-and-right"])
    assert "with the requests in the order 2, 1" in str(report)


def test_an_arbiter_that_draws_afresh_each_time_fails():
    """R10.1: equal inputs get equal answers."""
    source = np.random.default_rng(1)

    def fresh(**case: Any) -> list[Ruling]:
        return arbitrate(**{**case, "seed": int(source.integers(2**32))})

    assert not run_conformance(fresh, only=["ties"]).passed


class Broken(AdjudicatorUnderTest):
    """Right, but for one method."""

    def __init__(self, method: str, answer: Any) -> None:
        super().__init__("oracle")
        setattr(self, method, answer)


@pytest.mark.parametrize(
    ("method", "answer", "got"),
    [
        ("reset", lambda: 1, "raised TypeError"),
        ("withdraw", lambda _: 1 / 0, "raised ZeroDivisionError"),
        ("step", lambda *_: None, "None"),
        ("step", lambda *_: [], "0 of them"),
        ("read", dict, "None"),
        ("read", lambda: {"alive": [np.zeros(2)], "scores": [np.zeros(2)]}, "raised ValueError"),
        ("read", lambda: {"alive": np.array([7]), "scores": "many"}, "np.int64(7)"),
    ],
)
def test_whatever_an_arena_does_wrong_is_told_in_words(method: str, answer: Any, got: str):
    report = run_conformance(arena=Broken(method, answer), only=["inactive", "outages"])
    assert not report.passed
    assert any(got in difference.got for failure in report.failures for difference in failure.differences)


def test_an_arbiter_alone_does_not_pass_by_playing_nothing():
    report = run_conformance(arbitrate, only=["spawning"])
    assert not report.passed
    assert report.summary == "cases: 0 passed, 0 failed, 24 not played without an arena"


def test_an_arbiter_that_never_answers_is_interrupted_where_it_stands():
    """The case fails and the next one is played; one that swallows the interruption does not get away with it."""

    def loops(**case: Any) -> Any:
        with contextlib.suppress(TimeoutError):
            while case["hunters"]:
                pass
        while case["hunters"]:
            pass
        return []

    report = run_conformance(loops, only=["basics.in-reach", "basics.no-hunters-or-targets"], limit_s=1.0)
    (failure,) = report.failures
    (difference,) = failure.differences
    assert failure.case.id == "basics.in-reach"
    assert re.fullmatch(
        r"none: it raised TimeoutError: no answer within 1 s \(test_answers.py, line \d+\)", difference.got
    )
    report = run_conformance(loops, only=["claimants"], limit_s=0.1)
    assert re.fullmatch(r"cases: 0 passed, 3 failed, \d+ not played after 3 cases .* within 0.1 s", report.summary)


@pytest.mark.parametrize("limit_s", [0, -1.0, float("nan"), float("inf")])
def test_a_limit_that_is_no_time_is_refused(limit_s: float):
    with pytest.raises(ConfigError, match="limit_s must be a positive number of seconds, got"):
        run_conformance(arbitrate, limit_s=limit_s)


def test_a_play_that_went_otherwise_is_told_whole():
    """The report has settings and every part, so that the case can be played again by hand."""

    class Mute(AdjudicatorUnderTest):
        def read(self) -> dict[str, object]:
            return {}

    report = run_conformance(
        arena=Mute("oracle"),
        only=["time.driving-nearer", "inactive.for-good", "identity.", "time.clock", "prey.withdrawn"],
    )
    text = {failure.case.id: " ".join(str(failure).split()) for failure in report.failures}
    nearer, withdrawn = text["time.driving-nearer-than-the-winner"], text["prey.withdrawn"]
    assert "Settings: hunters = 2 Part 1: hunter 0 put at (4.75, 5.0, 0.0); hunter 1 put at (5.2, 5.0, 0.0)" in nearer
    assert "Part 2: hunter 0 driven by (2.0, 0.0); a step in which hunter 0 asks for 1; hunter 1 asks for 1" in nearer
    assert "Part 2: a step without requests Part 3: 9 steps without" in text["time.clock"]
    assert "hunter 0 withdrawn" in text["inactive.for-good"]
    assert "Part 2: reset" in text["identity.new-episode"]
    assert "prey 0 withdrawn; prey 0 driven by (1000.0, 0.0); a step without requests" in withdrawn


WICKED = "\ud800 \x1b[2J \0 \u202e ]]> <b>"


class OddError(Exception):
    def __repr__(self):
        raise RuntimeError(WICKED)

    __str__ = __repr__


def raises_a_liar(**_: Any) -> Any:
    raise OddError


def nested() -> list[Any]:
    found: list[Any] = []
    for _ in range(100_000):
        found = [found]
    return found


@pytest.mark.parametrize(
    "arbiter",
    [
        raises_a_liar,
        lambda *, requests, **_: [OddError()] * len(requests),
        lambda **_: WICKED,
        lambda *, requests, **_: [{"verdict": WICKED, "hunter": one, "target": OddError()} for one, _ in requests],
        lambda *, requests, **_: [("GRANTED", 10**5000, target, -(10**5000), 0) for _, target in requests],
        lambda **_: nested(),
    ],
)
def test_the_report_on_a_hostile_answer_is_text_and_xml(arbiter: Any):
    report = run_conformance(arbiter, only=["basics"], limit_s=None)
    assert report.failures
    for text in (str(report), report.in_full()):
        assert all(letter.isprintable() or letter == "\n" for letter in text)
    assert len(list(ET.fromstring(report.junit()).iter("failure"))) == len(report.failures)  # noqa: S314 - ours
