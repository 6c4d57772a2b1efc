"""Report of a run of the suite: as text for readers, and as JUnit XML for a build server."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from catch_arena.conformance.adjudicator_calls import counted
from catch_arena.conformance.comparison import Compared
from catch_arena.conformance.diagnosis import Diagnosis, diagnose
from catch_arena.conformance.results import Failure, Result, wrapped
from catch_arena.text import printable, printable_lines

_MOST_LINES: Final = 58
"""Length of a report by mistake, which is to fit on a page: as many of the first diagnoses as possible are in full."""
_MOST_NAMED: Final = 6
"""Number of further diagnoses of which one case is named; others are only counted."""
_MOST_LINES_OF_IDS: Final = 2


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
        """Return the failures by mistake, the passed cases by group if any failed, and the summary."""
        numbered = list(enumerate(self.diagnoses, start=1))
        in_full: list[str] = []
        text = self._counts()
        for number, diagnosis in numbered:
            in_full.append(self._diagnosis_text(number, diagnosis))
            longer = "\n\n".join([*in_full, *self._named(numbered[number:]), self._counts()])
            if number > 1 and longer.count("\n") >= _MOST_LINES:
                break
            text = longer
        return text

    def _named(self, rest: Sequence[tuple[int, Diagnosis]]) -> list[str]:
        """Return one paragraph with the headings of further diagnoses; nothing if there are none."""
        lines = ["More mistakes; --only with the id of a case shows it in full:"]
        lines += [
            f"{number}. {_heading(diagnosis)}, for example {diagnosis.failures[0].case.id}"
            for number, diagnosis in rest[:_MOST_NAMED]
        ]
        if left := rest[_MOST_NAMED:]:
            lines.append(f"and {len(left)} more, with {counted(sum(len(one.failures) for _, one in left), 'failure')}")
        return ["\n".join(map(wrapped, lines))] if rest else []

    def in_full(self) -> str:
        """Return every failure, the passed cases by group if any failed, and the summary."""
        return "\n\n".join([*map(str, self.failures), self._counts()])

    def _diagnosis_text(self, number: int, diagnosis: Diagnosis) -> str:
        """Return a diagnosis as text: its heading, its first failure, and the names of the others."""
        first, *remaining = diagnosis.failures
        lines = [wrapped(f"{number}. {_heading(diagnosis)}")]
        if diagnosis.rule:
            lines.append(wrapped(diagnosis.rule))
        lines.append(first.describe(brief=True))
        if remaining:
            lines.append(wrapped(f"{len(remaining)} more: {self._names(remaining)}", max_lines=_MOST_LINES_OF_IDS))
        return "\n".join(lines)

    def _names(self, failures: Sequence[Failure]) -> str:
        """Return the ids of failures by group; "all" and their number for a group whose played cases are all here."""
        names: dict[str, list[str]] = {}
        for failure in failures:
            names.setdefault(failure.case.group, []).append(failure.case.id.partition(".")[2])
        return "; ".join(
            f"{group}: {f'all {len(ids)}' if len(ids) == self._groups[group] else ', '.join(ids)}"
            for group, ids in sorted(names.items())
        )

    @cached_property
    def _groups(self) -> Counter[str]:
        return Counter(result.case.group for result in self.results if result.played)

    def _counts(self) -> str:
        """Return the summary, after the number of passed cases of each group if any failed."""
        failed = Counter(failure.case.group for failure in self.failures)
        passed = ", ".join(f"{group} {count - failed[group]} of {count}" for group, count in self._groups.items())
        return "\n\n".join([*([wrapped(f"passed: {passed}")] if failed else []), wrapped(self.summary)])

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


def _heading(diagnosis: Diagnosis) -> str:
    """Return a diagnosis's cause and its number of failures."""
    cause = f'looks like "{diagnosis.looks_like}"' if diagnosis.known else diagnosis.looks_like
    return f"{cause}: {counted(len(diagnosis.failures), 'failure')}"
