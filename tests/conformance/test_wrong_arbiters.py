"""The suite is tested too: each wrong arbiter is caught by the group of cases that is about its mistake, and named."""

import json
import sys
import textwrap
from functools import cache

import pytest
from conformance.wrong_arbiters import KNOWN, WRONG, LooksUpFirst, PlainArbiter

from catch_arena.conformance.answers import KINDS
from catch_arena.conformance.case_files import load_cases
from catch_arena.conformance.cases import ArbiterCase
from catch_arena.conformance.diagnosis import Mistake, known_mistakes
from catch_arena.testing import run_conformance


@cache
def failed_by(wrong: type[PlainArbiter]) -> dict[str, list[str]]:
    """The ids of the cases that it fails, by what differs."""
    failed: dict[str, list[str]] = {kind: [] for kind in KINDS}
    for failure in run_conformance(wrong()).failures:
        failed[failure.kind].append(failure.case.id)
    return failed


def grouped(ids: list[str]) -> dict[str, tuple[str, ...]]:
    groups: dict[str, tuple[str, ...]] = {}
    for id_ in ids:
        group, _, name = id_.partition(".")
        groups[group] = (*groups.get(group, ()), name)
    return groups


def test_a_right_arbiter_with_lots_of_its_own_passes():
    """Any one of the tied may win, if it is one only and always the same."""
    report = run_conformance(PlainArbiter())
    assert report.passed, str(report)
    assert not run_conformance(PlainArbiter(), only=["ties"], exact_lots=True).passed


@pytest.mark.parametrize(("wrong", "group"), WRONG, ids=[f"{group}-{wrong.__name__}" for wrong, group in WRONG])
def test_a_wrong_arbiter_is_caught_by_its_group(wrong: type[PlainArbiter], group: str):
    """With words that say what is wrong, and not with many."""
    report = run_conformance(wrong(), only=[f"{group}."])
    assert report.failures
    for failure in report.failures:
        assert failure.case.group == group
        assert all(difference.expected != difference.got for difference in failure.differences)
    assert str(report).count("\n") < 20 * len(report.diagnoses) + 4


def test_every_group_with_cases_for_arbiters_catches_one():
    groups = {case.group for case in load_cases() if isinstance(case, ArbiterCase)}
    assert groups == {group for _, group in WRONG}


def test_every_wrong_arbiter_but_one_that_raises_is_a_known_mistake():
    assert {wrong for wrong, _ in WRONG} - {LooksUpFirst} <= set(KNOWN)
    assert [one.looks_like for one in known_mistakes()] == [name for name, _ in KNOWN.values()]


@pytest.mark.parametrize("wrong", KNOWN, ids=[wrong.__name__ for wrong in KNOWN])
def test_the_table_has_the_cases_that_a_mistake_fails(wrong: type[PlainArbiter]):
    """And nothing but the arbiter's mistake is named for it."""
    looks_like, rule = KNOWN[wrong]
    ours = next(one for one in known_mistakes() if one.looks_like == looks_like)
    assert ours == Mistake(
        looks_like=looks_like, rule=rule, **{kind: grouped(ids) for kind, ids in failed_by(wrong).items()}
    )
    report = run_conformance(wrong())
    (diagnosis,) = report.diagnoses
    assert (diagnosis.looks_like, diagnosis.rule, diagnosis.known) == (looks_like, rule, True)
    assert diagnosis.failures == report.failures


def as_toml(wrong: type[PlainArbiter]) -> str:
    looks_like, rule = KNOWN[wrong]
    lines = ["[[mistake]]", f"looks_like = {json.dumps(looks_like)}", f"rule = {json.dumps(rule)}"]
    for kind, ids in failed_by(wrong).items():
        lines += [f"[mistake.{kind}]"] if ids else []
        for group, names in grouped(ids).items():
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


if __name__ == "__main__":  # prints the tables of mistakes.toml
    sys.stdout.write("\n".join(map(as_toml, KNOWN)))
