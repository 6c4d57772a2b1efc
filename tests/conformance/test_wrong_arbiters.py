"""Wrong arbiters fail exactly the cases that mistakes.toml lists, and their reports name the mistake."""

import json
import sys
import textwrap
from functools import cache

import pytest
from conformance.wrong_arbiters import KNOWN, PlainArbiter

from catch_arena.conformance.adjudicator_calls import KINDS
from catch_arena.conformance.cases import ArbiterCase, load_cases
from catch_arena.conformance.results import known_mistakes
from catch_arena.testing import Report, run_conformance

MISTAKES = {one.looks_like: one for one in known_mistakes()}


@cache
def report_of(mistake: str) -> Report:
    return run_conformance(KNOWN[mistake])


def failed_by(mistake: str) -> dict[str, dict[str, tuple[str, ...]]]:
    """Names of the failed cases by group, for each kind of difference."""
    failed: dict[str, dict[str, tuple[str, ...]]] = {kind: {} for kind in KINDS}
    for failure in report_of(mistake).failures:
        group, _, name = failure.case.id.partition(".")
        failed[failure.kind][group] = (*failed[failure.kind].get(group, ()), name)
    return failed


def test_a_right_arbiter_with_lots_of_its_own_passes():
    """Any one of the tied may win, if it is one only and always the same."""
    report = run_conformance(PlainArbiter())
    assert report.passed, str(report)
    assert not run_conformance(PlainArbiter(), only=["ties"], exact_lots=True).passed


def test_every_group_with_cases_for_arbiters_catches_a_mistake():
    caught = {group for one in MISTAKES.values() for kind in KINDS for group in getattr(one, kind)}
    assert caught == {case.group for case in load_cases() if isinstance(case, ArbiterCase)}


def test_every_known_mistake_has_an_arbiter():
    assert list(MISTAKES) == list(KNOWN)


@pytest.mark.parametrize("mistake", KNOWN)
def test_the_table_has_the_cases_that_a_mistake_fails(mistake: str):
    """The report names that mistake alone, and gives its rule."""
    known = MISTAKES[mistake]
    assert {kind: dict(getattr(known, kind)) for kind in KINDS} == failed_by(mistake)
    report = report_of(mistake)
    (diagnosis,) = report.diagnoses
    assert (diagnosis.looks_like, diagnosis.rule, diagnosis.known) == (mistake, known.rule, True)
    assert {one.case.id for one in diagnosis.failures} == {one.case.id for one in report.failures}
    assert str(report).count("\n") < 30
    text, count = " ".join(str(report).split()), len(report.failures)
    assert text.startswith(f'1. looks like "{mistake}": {count} failure')
    assert text.count("Why it matters: ") == 1
    assert (f"{count - 1} more: " in text) == (count > 1)
    assert report.in_full().count("Why it matters: ") == count


def as_toml(mistake: str) -> str:
    lines = ["[[mistake]]", f"looks_like = {json.dumps(mistake)}", f"rule = {json.dumps(MISTAKES[mistake].rule)}"]
    for kind, groups in failed_by(mistake).items():
        lines += [f"[mistake.{kind}]"] if groups else []
        for group, names in groups.items():
            words = ", ".join(map(json.dumps, names))
            line = f"{group} = [{words}]"
            if len(line) > 120:
                indent = "  "
                filled = textwrap.fill(
                    f"{words},", 118, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False
                )
                line = f"{group} = [\n{filled}\n]"
            lines.append(line)
    return "\n".join([*lines, ""])


if __name__ == "__main__":  # prints the tables of mistakes.toml, with the rules that stand there
    sys.stdout.write("\n".join(map(as_toml, KNOWN)))
