"""Result of one case, with a description of its failure."""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from catch_arena.conformance.adjudicator_calls import KINDS, Difference
from catch_arena.conformance.cases import DEFAULTS, ArbiterCase, ArenaCase, CaseStep, ExpectedRuling
from catch_arena.text import shortened

_WIDTH: Final = 80
"""Longest line of a report, unless a word is longer [characters]."""
_MOST_DIFFERENCES: Final = 6
_BRIEF_DIFFERENCES, _BRIEF_LINES = 2, 3
"""Limits of a brief description of a case: the number of differences, and the lines of each other paragraph."""


@dataclass(frozen=True, slots=True)
class Failure:
    """One case in which an adjudicator's answer differs from the rulebook's."""

    case: ArbiterCase | ArenaCase
    variation: str
    """Description of the variant or part that failed; "" for the unchanged case."""
    differences: tuple[Difference, ...]

    @property
    def kind(self) -> str:
        """Kind of the failure, from those of its differences: see KINDS; "" if none has a kind."""
        found = {difference.kind for difference in self.differences}
        if found >= {"granted", "refused"}:
            return "winner"
        return next((kind for kind in KINDS if kind in found), "")

    def __str__(self) -> str:
        """Return the failure as text: case, clauses, expected and given answer, and why it matters."""
        return self.describe()

    def describe(self, *, brief: bool = False) -> str:
        """Return the failure as text (see `__str__`), which `brief` cuts."""
        case = self.case
        if isinstance(case, ArbiterCase):
            paragraphs = [f"Position: {_position(case)}", f"Requests: {_requests(case.expected)}"]
        else:
            paragraphs = [f"Settings: {_settings(case)}"]
            paragraphs += [f"Part {part}: {_case_step(step)}" for part, step in enumerate(case.play, start=1)]
        if self.variation:
            paragraphs.append(f"It was played {self.variation}.")
        limit = _BRIEF_DIFFERENCES if brief else _MOST_DIFFERENCES
        differences = [str(difference) for difference in self.differences[:limit]]
        if (left := len(self.differences) - limit) > 0:
            differences.append(f"and {left} more")
        why = f"Why it matters: {case.why}"
        if case.options:
            why += f" The rulebook chose «{case.options[0]}», not {_either(case.options[1:])}."
        lines = [wrapped(f"FAILED {case.id} ({', '.join(case.clauses)}): {case.situation}")]
        lines += [wrapped(text, "  ", _BRIEF_LINES if brief else None) for text in paragraphs]
        lines += [wrapped(text, "  ") for text in (*differences, why)]
        return "\n".join(lines)


@dataclass(frozen=True, slots=True)
class Result:
    """Result of one case."""

    case: ArbiterCase | ArenaCase
    failure: Failure | None
    seconds: float
    left_out: str = ""
    """Reason why the case was not played, such as "not played without an arena"; "" if it was played."""

    @property
    def played(self) -> bool:
        """True if the case was played."""
        return not self.left_out


def wrapped(text: str, indent: str = "", max_lines: int | None = None) -> str:
    """Return a text in lines, all but the first indented by two more characters; it is cut off after `max_lines`."""
    return textwrap.fill(
        text,
        _WIDTH,
        initial_indent=indent,
        subsequent_indent=f"{indent}  ",
        break_on_hyphens=False,
        break_long_words=False,
        max_lines=max_lines,
        placeholder=" ...",
    )


def _position(case: ArbiterCase) -> str:
    """Return the places of hunters and targets, and the arguments that differ from the defaults."""
    hunters = [f"hunter {seat} at ({x}, {y})" for seat, (x, y) in enumerate(case.hunters)]
    targets = [f"{shortened(name)} at ({x}, {y})" for name, (x, y) in case.targets.items()]
    given = case.arguments()
    unusual = [f"{key} = {given[key]!r}" for key, value in case.circumstances.items() if value != DEFAULTS[key]]
    return "; ".join([*hunters, *targets, *unusual]) or "no hunters and no targets"


def _settings(case: ArenaCase) -> str:
    return "; ".join(f"{key} = {value!r}" for key, value in case.settings.items())


def _case_step(step: CaseStep) -> str:
    """Return the events of one part of a play, in their order."""
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
        events += [f"hunter {seat} driven by {(v, w)}" for seat, v, w in step.drive]
        events += [f"prey {index} driven by {(v, w)}" for index, v, w in step.drive_prey]
        events.append(f"a step in which {_requests(step.expected)}" if step.expected else "a step without requests")
    return "; ".join(events) or "only the state is read"


def _requests(expected: Sequence[ExpectedRuling]) -> str:
    return "; ".join(f"hunter {ruling.hunter} asks for {shortened(ruling.target)}" for ruling in expected) or "none"


def _either(options: Sequence[str]) -> str:
    return " or ".join(f"«{option}»" for option in options)
