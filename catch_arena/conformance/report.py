"""Report of a run of the suite: as text for readers, and as JUnit XML for a build server."""

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import Final
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from catch_arena.conformance.comparison import Compared
from catch_arena.conformance.results import Diagnosis, Failure, Result, diagnose, wrapped
from catch_arena.text import counted, printable, printable_lines

_MOST_LINES: Final = 44
"""Length of the diagnoses that a report has in full [lines]: with the rest it fits on a page."""
_MOST_OTHERS: Final = 8
"""Number of further mistakes that are named."""


@dataclass(frozen=True)
class Report:
    """Results of all selected cases."""

    results: tuple[Result, ...]
    compared: Compared
    """The parts of the answers that were compared."""

    @property
    def failures(self) -> tuple[Failure, ...]:
        """The cases that failed, in the order of the suite."""
        return tuple(result.failure for result in self.results if result.failure is not None)

    @property
    def passed(self) -> bool:
        """True if no case failed and at least one was played."""
        return not self.failures and any(result.played for result in self.results)

    @cached_property
    def diagnoses(self) -> tuple[Diagnosis, ...]:
        """The failures grouped by their causes; each failure is in one diagnosis."""
        return diagnose(self.results, self.compared)

    @property
    def summary(self) -> str:
        """One line with the numbers of cases that passed, failed, and could not be played."""
        played = sum(result.played for result in self.results)
        failed = len(self.failures)
        left_out = Counter(result.left_out for result in self.results if not result.played)
        return ", ".join(
            [f"cases: {played - failed} passed", f"{failed} failed", *(f"{left_out[why]} {why}" for why in left_out)]
        )

    def __str__(self) -> str:
        """Return the first diagnoses in full, the causes of the others, and the summary."""
        texts = [_diagnosis_text(number, diagnosis) for number, diagnosis in enumerate(self.diagnoses, start=1)]
        shown = 1
        while shown < len(texts) and "\n\n".join(texts[: shown + 1]).count("\n") < _MOST_LINES:
            shown += 1
        others = sorted(self.diagnoses[shown:], key=lambda one: -len(one.failures))
        lines = ["More mistakes:", *(wrapped(_heading(one), "  ", 1) for one in others[:_MOST_OTHERS])]
        if len(others) > _MOST_OTHERS:
            lines.append(f"  ... and {len(others) - _MOST_OTHERS} more")
        more = ["\n".join(lines)] if others else []
        return "\n\n".join([*texts[:shown], *more, wrapped(self.summary)])

    def in_full(self) -> str:
        """Return every failure, and the summary."""
        return "\n\n".join([*map(str, self.failures), wrapped(self.summary)])

    def junit(self) -> str:
        """Return the report as JUnit XML, with one test case for each case."""
        totals = {
            "tests": str(len(self.results)),
            "failures": str(len(self.failures)),
            "errors": "0",
            "skipped": str(sum(not result.played for result in self.results)),
            "time": f"{sum(result.seconds for result in self.results):.3f}",
        }
        root = Element("testsuites", {"name": "catch-arena conformance", **totals})
        suite = SubElement(root, "testsuite", {"name": "catch-arena conformance", **totals})
        for result in self.results:
            case = result.case
            test = SubElement(
                suite,
                "testcase",
                {"classname": f"conformance.{case.group}", "name": case.id, "time": f"{result.seconds:.3f}"},
            )
            if result.failure is not None:
                message = f"{', '.join(case.clauses)}: {result.failure.differences[0]}"
                failure = SubElement(test, "failure", {"type": "conformance", "message": printable(message)})
                failure.text = printable_lines(str(result.failure))
            elif not result.played:
                SubElement(test, "skipped", {"message": result.left_out})
        indent(root)
        return f'<?xml version="1.0" encoding="UTF-8"?>\n{tostring(root, encoding="unicode")}\n'


def _diagnosis_text(number: int, diagnosis: Diagnosis) -> str:
    """Return a diagnosis as text: its heading, its first failure, and the ids of the others."""
    first, *others = diagnosis.failures
    lines = [wrapped(f"{number}. {_heading(diagnosis)}")]
    if diagnosis.rule:
        lines.append(wrapped(diagnosis.rule))
    lines.append(first.describe(brief=True))
    if others:
        ids = ", ".join(failure.case.id for failure in others)
        lines.append(wrapped(f"{len(others)} more: {ids}", max_lines=2))
    return "\n".join(lines)


def _heading(diagnosis: Diagnosis) -> str:
    """Return a diagnosis's cause and its number of failures."""
    cause = f'looks like "{diagnosis.looks_like}"' if diagnosis.known else diagnosis.looks_like
    return f"{cause}: {counted(len(diagnosis.failures), 'failure')}"
