"""Arbiters whose every answer is hostile: the report is text, for people and as XML."""

from xml.etree import ElementTree as ET

import pytest

from catch_arena.testing import run_conformance

WICKED = "\ud800 \x1b[2J \0 \u202e ]]> <b>"


class LyingError(Exception):
    def __str__(self):
        raise ValueError(WICKED)


class Odd:
    def __repr__(self):
        raise RuntimeError(WICKED)


def raises(**_):
    raise RuntimeError(WICKED)


def raises_a_liar(**_):
    raise LyingError


def raises_a_wicked_class(**_):
    raise type(WICKED.replace("\0", "").replace("\ud800", ""), (Exception,), {})


def answers(part):
    def arbiter(*, requests, **_):
        return [{"verdict": "GRANTED", "hunter": hunter, "target": target} | part for hunter, target in requests]

    return arbiter


def names_itself_a_list(**_):
    return type("list", (), {"__iter__": lambda _: iter(()), "__len__": lambda _: 1 // 0})()


ARBITERS = {
    "raises": raises,
    "raises a liar": raises_a_liar,
    "raises a wicked class": raises_a_wicked_class,
    "is odd": lambda **_: Odd(),
    "is odd within": lambda *, requests, **_: [Odd()] * len(requests),
    "is no list": names_itself_a_list,
    "is wicked text": lambda **_: WICKED,
    "wicked verdicts": answers({"verdict": WICKED}),
    "wicked targets": answers({"target": WICKED}),
    "odd targets": answers({"target": Odd()}),
    "huge hunters": answers({"hunter": 10**5000}),
    "huge distances": answers({"distance_um": -(10**5000), "winner": 10**5000}),
    "deep": lambda **_: deep(),
}


def deep():
    found = []
    for _ in range(100_000):
        found = [found]
    return found


@pytest.mark.parametrize("name", ARBITERS)
def test_whatever_an_arbiter_answers_the_report_is_text(name):
    report = run_conformance(ARBITERS[name], only=["basics", "reach"], limit_s=None)
    assert report.failures
    assert not report.passed
    for text in (str(report), report.in_full()):
        assert all(letter.isprintable() or letter == "\n" for letter in text)
    cases = list(ET.fromstring(report.junit()).iter("failure"))  # noqa: S314 - ours
    assert len(cases) == len(report.failures)
