"""Report of a run of the suite: as text for readers, and as JUnit XML for a build server."""

import textwrap
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from catch_arena.conformance.adjudicator_calls import counted
from catch_arena.conformance.comparison import Compared
from catch_arena.conformance.diagnosis import Diagnosis, diagnose
from catch_arena.conformance.results import WIDTH, Failure, Result, wrapped
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
        return self.by_mistake(WIDTH)

    def by_mistake(self, width: int) -> str:
        """Return the report by mistake (see `__str__`), in lines of at most `width` characters."""
        numbered = list(enumerate(self.diagnoses, start=1))
        last = [*self._by_group(width), wrapped(self.summary, width, "", "  ")]
        in_full: list[str] = []
        text = "\n\n".join(last)
        for number, diagnosis in numbered:
            in_full.append(self._diagnosis_text(number, diagnosis, width))
            longer = "\n\n".join([*in_full, *self._named(numbered[number:], width), *last])
            if number > 1 and longer.count("\n") >= _MOST_LINES:
                break
            text = longer
        return text

    def _named(self, rest: Sequence[tuple[int, Diagnosis]], width: int) -> list[str]:
        """Return one paragraph with the headings of further diagnoses; nothing if there are none."""
        lines = ["More mistakes; --only with the id of a case shows it in full:"]
        lines += [
            f"{number}. {_heading(diagnosis)}, for example {diagnosis.failures[0].case.id}"
            for number, diagnosis in rest[:_MOST_NAMED]
        ]
        if left := rest[_MOST_NAMED:]:
            lines.append(f"and {len(left)} more, with {counted(sum(len(one.failures) for _, one in left), 'failure')}")
        return ["\n".join(wrapped(line, width, "", "   ") for line in lines)] if rest else []

    def in_full(self, width: int = WIDTH) -> str:
        """Return every failure, the passed cases by group if any failed, and the summary."""
        failures = (failure.describe(width) for failure in self.failures)
        return "\n\n".join([*failures, *self._by_group(width), wrapped(self.summary, width, "", "  ")])

    def _diagnosis_text(self, number: int, diagnosis: Diagnosis, width: int) -> str:
        """Return a diagnosis as text: its heading, its first failure, and the names of the others."""
        first, *remaining = diagnosis.failures
        lines = [
            wrapped(f"{number}. {_heading(diagnosis)}", width, "", "   "),
            *([wrapped(diagnosis.rule, width, "   ")] if diagnosis.rule else []),
            textwrap.indent(first.describe(width - 3, brief=True), "   "),
        ]
        if remaining:
            names = f"{len(remaining)} more: {self._names(remaining)}"
            lines.append(wrapped(names, width, "   ", "     ", _MOST_LINES_OF_IDS))
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

    def _by_group(self, width: int) -> list[str]:
        """Return one paragraph with the number of passed cases of each group; nothing if no case failed."""
        failed = Counter(failure.case.group for failure in self.failures)
        passed = ", ".join(f"{group} {count - failed[group]} of {count}" for group, count in self._groups.items())
        return [wrapped(f"passed: {passed}", width, "", "  ")] if failed else []

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
