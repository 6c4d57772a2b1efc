"""What came of a run of the suite: for people in words, for a build server as JUnit XML."""

import textwrap
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from catch_arena.conformance.answers import Difference, shown
from catch_arena.conformance.cases import DEFAULTS, ArbiterCase, Asked, Beat, WorldCase

_WIDTH: Final = 100
_MOST_DIFFERENCES: Final = 6


@dataclass(frozen=True, slots=True)
class Failure:
    """One case that an adjudicator answers otherwise than the rulebook."""

    case: ArbiterCase | WorldCase
    how: str
    """How the case was played when it failed; "" as it stands."""
    differences: tuple[Difference, ...]

    def __str__(self) -> str:
        """Case, clauses, expected, got, and why it matters."""
        case = self.case
        lines = [f"FAILED {case.id} ({', '.join(case.clauses)})", *_paragraph(case.situation)]
        if isinstance(case, ArbiterCase):
            lines += _paragraph(f"Position: {_position(case)}")
            lines += _paragraph(f"Requests: {_requests(case.asked)}")
        else:
            lines += _paragraph(f"Settings: {_settings(case)}")
            for part, beat in enumerate(case.play, start=1):
                lines += _paragraph(f"Part {part}: {_beat(beat)}")
        if self.how:
            lines += _paragraph(f"It was played {self.how}.")
        for difference in self.differences[:_MOST_DIFFERENCES]:
            lines += [
                f"    {difference.about}",
                f"      expected {difference.expected}",
                f"      got      {difference.got}",
            ]
        if (left := len(self.differences) - _MOST_DIFFERENCES) > 0:
            lines.append(f"    and {left} more")
        lines += _paragraph(f"Why it matters: {case.why}")
        if case.options:
            lines += _paragraph(f"The rulebook chose «{case.options[0]}», not {_either(case.options[1:])}.")
        return "\n".join(lines)


@dataclass(frozen=True, slots=True)
class Result:
    """What came of one case."""

    case: ArbiterCase | WorldCase
    failure: Failure | None
    seconds: float
    played: bool = True
    """False where the case needs an arena, or an arbiter, and there was none."""

    @property
    def needs(self) -> str:
        """What the case is played on, for one that was not."""
        return "an arbiter" if isinstance(self.case, ArbiterCase) else "an arena"


@dataclass(frozen=True, slots=True)
class Report:
    """What came of all cases that were asked for."""

    results: tuple[Result, ...]

    @property
    def failures(self) -> tuple[Failure, ...]:
        """The cases that failed, in the order of the suite."""
        return tuple(result.failure for result in self.results if result.failure is not None)

    @property
    def passed(self) -> bool:
        """Whether every case that was played was answered as the rulebook does, and at least one was."""
        return not self.failures and any(result.played for result in self.results)

    @property
    def summary(self) -> str:
        """One line: how many passed, how many failed, and how many could not be played."""
        played = sum(result.played for result in self.results)
        failed = len(self.failures)
        left = Counter(result.needs for result in self.results if not result.played)
        counts = [
            f"{played - failed} passed",
            f"{failed} failed",
            *(f"{count} need {what}" for what, count in left.items()),
        ]
        return f"cases: {', '.join(counts)}"

    def __str__(self) -> str:
        """Every failure, how each group fared if any failed, and the summary."""
        groups = Counter(result.case.group for result in self.results if result.played)
        failed = Counter(failure.case.group for failure in self.failures)
        fared = [f"{group:<12} {count - failed[group]:>3} of {count} passed" for group, count in groups.items()]
        return "\n\n".join([*map(str, self.failures), *(["\n".join(fared)] if failed else []), self.summary])

    def junit(self) -> str:
        """The report as JUnit XML, one test case for each case."""
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
                first = result.failure.differences[0]
                message = f"{', '.join(case.clauses)}: {first.about}: expected {first.expected}, got {first.got}"
                failure = SubElement(test, "failure", {"type": "conformance", "message": message})
                failure.text = str(result.failure)
            elif not result.played:
                SubElement(test, "skipped", {"message": f"needs {result.needs}"})
        indent(root)
        return f'<?xml version="1.0" encoding="UTF-8"?>\n{tostring(root, encoding="unicode")}\n'


def _position(case: ArbiterCase) -> str:
    """Where everybody is, and what is not as usual."""
    hunters = [f"hunter {seat} at ({x}, {y})" for seat, (x, y) in enumerate(case.hunters)]
    targets = [f"{shown(name)} at ({x}, {y})" for name, (x, y) in case.targets.items()]
    given = case.arguments()
    unusual = [f"{key} = {given[key]!r}" for key, value in case.circumstances.items() if value != DEFAULTS[key]]
    return "; ".join([*hunters, *targets, *unusual]) or "nobody and nothing"


def _settings(case: WorldCase) -> str:
    return "; ".join(f"{key} = {value!r}" for key, value in case.settings.items())


def _beat(beat: Beat) -> str:
    """What happens in one part of a play, in the order in which it does."""
    told = ["reset"] if beat.reset else []
    if beat.hunters is not None:
        told += [f"hunter {seat} put at {pose}" for seat, pose in enumerate(beat.hunters)]
        told += [f"a target put at {place}" for place in beat.targets]
    if beat.withdraw is not None:
        told.append(f"hunter {beat.withdraw} withdrawn")
    if beat.steps:
        told.append("a step without requests" if beat.steps == 1 else f"{beat.steps} steps without requests")
    if beat.asked is not None:
        told += [f"hunter {seat} driven by {velocities}" for seat, velocities in beat.drive.items()]
        told.append(f"a step in which {_requests(beat.asked)}" if beat.asked else "a step without requests")
    return "; ".join(told) or "only looked at"


def _requests(asked: Sequence[Asked]) -> str:
    return "; ".join(f"hunter {one.hunter} asks for {shown(one.name)}" for one in asked) or "none"


def _paragraph(text: str) -> list[str]:
    return textwrap.wrap(text, _WIDTH, initial_indent="  ", subsequent_indent="  ")


def _either(options: Sequence[str]) -> str:
    return " or ".join(f"«{option}»" for option in options)
