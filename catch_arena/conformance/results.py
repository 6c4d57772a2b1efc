"""What came of one case, in words where it failed."""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

from catch_arena.conformance.answers import KINDS, Difference
from catch_arena.conformance.cases import DEFAULTS, ArbiterCase, ArenaCase, CaseStep, ExpectedRuling
from catch_arena.text import in_short

WIDTH: Final = 100
"""Of a report, in characters, where nobody asks for another one."""
_MOST_DIFFERENCES: Final = 6
_BRIEF_DIFFERENCES, _BRIEF_LINES = 2, 3
"""Of a large case, in brief: how many differences, and lines of anything else."""


@dataclass(frozen=True, slots=True)
class Failure:
    """One case that an adjudicator answers otherwise than the rulebook."""

    case: ArbiterCase | ArenaCase
    how: str
    """How the case was played when it failed; "" as it stands."""
    differences: tuple[Difference, ...]

    @property
    def kind(self) -> str:
        """The strongest kind of its differences: see `answers.KINDS`."""
        found = {one.kind for one in self.differences}
        return next((kind for kind in KINDS if kind in found), "")

    def __str__(self) -> str:
        """Case, clauses, expected, got, and why it matters."""
        return self.in_words(WIDTH)

    def in_words(self, width: int, *, brief: bool = False) -> str:
        """The same, in lines of at most so many characters; `brief`, what is long is cut off."""
        case = self.case
        if isinstance(case, ArbiterCase):
            paragraphs = [f"Position: {_position(case)}", f"Requests: {_requests(case.expected)}"]
        else:
            paragraphs = [f"Settings: {_settings(case)}"]
            paragraphs += [f"Part {part}: {_case_step(step)}" for part, step in enumerate(case.play, start=1)]
        if self.how:
            paragraphs.append(f"It was played {self.how}.")
        most = _BRIEF_DIFFERENCES if brief else _MOST_DIFFERENCES
        differences = [str(one) for one in self.differences[:most]]
        if (left := len(self.differences) - most) > 0:
            differences.append(f"and {left} more")
        why = f"Why it matters: {case.why}"
        if case.options:
            why += f" The rulebook chose «{case.options[0]}», not {_either(case.options[1:])}."
        lines = [wrapped(f"FAILED {case.id} ({', '.join(case.clauses)}): {case.situation}", width, "", "  ")]
        lines += [wrapped(text, width, "  ", "    ", _BRIEF_LINES if brief else None) for text in paragraphs]
        lines += [wrapped(text, width, "  ", "    ") for text in (*differences, why)]
        return "\n".join(lines)


class LeftOut(NamedTuple):
    """Why a case was not played: in words that follow it, and in words that follow several."""

    of_one: str
    of_several: str


_NEEDS_ARBITER: Final = LeftOut("needs an arbiter", "need an arbiter")
_NEEDS_ARENA: Final = LeftOut("needs an arena", "need an arena")


def needs(case: ArbiterCase | ArenaCase) -> LeftOut:
    """Why a case was not played where there was nothing to play it on."""
    return _NEEDS_ARBITER if isinstance(case, ArbiterCase) else _NEEDS_ARENA


@dataclass(frozen=True, slots=True)
class Result:
    """What came of one case."""

    case: ArbiterCase | ArenaCase
    failure: Failure | None
    seconds: float
    left_out: LeftOut | None = None
    """Why it was not played; None where it was."""

    @property
    def played(self) -> bool:
        """Whether it was."""
        return self.left_out is None


def wrapped(text: str, width: int, first: str = "", then: str | None = None, most: int | None = None) -> str:
    """A text in lines of at most so many characters, where its words allow that, with what begins the lines; cut off
    after `most` lines.
    """
    return textwrap.fill(
        text,
        width,
        initial_indent=first,
        subsequent_indent=first if then is None else then,
        break_on_hyphens=False,
        break_long_words=False,
        max_lines=most,
        placeholder=" ...",
    )


def _position(case: ArbiterCase) -> str:
    """Where everybody is, and what is not as usual."""
    hunters = [f"hunter {seat} at ({x}, {y})" for seat, (x, y) in enumerate(case.hunters)]
    targets = [f"{in_short(name)} at ({x}, {y})" for name, (x, y) in case.targets.items()]
    given = case.arguments()
    unusual = [f"{key} = {given[key]!r}" for key, value in case.circumstances.items() if value != DEFAULTS[key]]
    return "; ".join([*hunters, *targets, *unusual]) or "nobody and nothing"


def _settings(case: ArenaCase) -> str:
    return "; ".join(f"{key} = {value!r}" for key, value in case.settings.items())


def _case_step(step: CaseStep) -> str:
    """What happens in one part of a play, in the order in which it does."""
    events = ["reset"] if step.reset else []
    if step.hunters is not None:
        events += [f"hunter {seat} put at {pose}" for seat, pose in enumerate(step.hunters)]
        events += [f"a target put at {place}" for place in step.targets]
    if step.withdraw is not None:
        events.append(f"hunter {step.withdraw} withdrawn")
    if step.withdraw_prey is not None:
        events.append(f"prey {step.withdraw_prey} withdrawn")
    if step.steps:
        events.append("a step without requests" if step.steps == 1 else f"{step.steps} steps without requests")
    if step.expected is not None:
        events += [f"hunter {seat} driven by {velocities}" for seat, velocities in step.drive.items()]
        events += [f"prey {index} driven by {velocities}" for index, velocities in step.drive_prey.items()]
        events.append(f"a step in which {_requests(step.expected)}" if step.expected else "a step without requests")
    return "; ".join(events) or "only looked at"


def _requests(expected: Sequence[ExpectedRuling]) -> str:
    return "; ".join(f"hunter {one.hunter} asks for {in_short(one.target)}" for one in expected) or "none"


def _either(options: Sequence[str]) -> str:
    return " or ".join(f"«{option}»" for option in options)
