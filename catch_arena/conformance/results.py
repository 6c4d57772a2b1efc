"""Results of cases, with a description of each failure, and the causes of failures.

A cause is an error that is raised, a known mistake that fails the same cases, or a clause.
"""

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Final

import msgspec

from catch_arena.conformance.adjudicator_calls import KINDS, OF_GRANTS, Difference, NoRuling
from catch_arena.conformance.cases import ArbiterCase, ArenaCase, CaseStep, ExpectedRuling
from catch_arena.conformance.comparison import Compared
from catch_arena.files import tomllib
from catch_arena.text import shortened

_BRIEF_DIFFERENCES, _BRIEF_LINES = 2, 3
"""Limits of a brief description of a case: the number of differences, and the lines of each other paragraph."""
_TOLERATED: Final = 0.1
"""Largest number of cases that may contradict a mistake, as a share of the cases that it explains."""

_WEAKNESS: Final = {**dict.fromkeys(OF_GRANTS, 0), "verdict": 1, "evidence": 2, "": 3}
"""Kinds of failures from wrong grants, the strongest, to those without a kind."""

Ids = Mapping[str, tuple[str, ...]]
"""Names of cases by group."""


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
        differences = [str(difference) for difference in self.differences]
        if brief and (left := len(differences) - _BRIEF_DIFFERENCES) > 0:
            differences[_BRIEF_DIFFERENCES:] = [f"and {left} more"]
        why = f"Why it matters: {case.why}"
        if case.options:
            chosen, *others = (f"«{option}»" for option in case.options)
            why += f" The rulebook chose {chosen}, not {' or '.join(others)}."
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


class Mistake(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A wrong rule, and the cases that an arbiter with it fails: a table of mistakes.toml."""

    looks_like: str
    rule: str
    winner: Ids = {}
    granted: Ids = {}
    refused: Ids = {}
    verdict: Ids = {}
    evidence: Ids = {}
    """Cases that it fails, by the kind of failure (KINDS)."""

    def kinds(self, compared: Compared) -> dict[str, str]:
        """Return the kinds of its failures under a comparison: one of KINDS by the ids of cases."""
        found = {"evidence": KINDS, "verdicts": KINDS[:-1], "success": OF_GRANTS}[compared]
        return {
            f"{group}.{name}": kind for kind in found for group, names in getattr(self, kind).items() for name in names
        }


@cache
def known_mistakes() -> tuple[Mistake, ...]:
    """Return the mistakes in the order of mistakes.toml; of two that fit equally well the first is named."""
    text = (files("catch_arena.conformance") / "mistakes.toml").read_text(encoding="utf-8")
    return msgspec.convert(tomllib.loads(text)["mistake"], tuple[Mistake, ...])


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """Failures that have something in common."""

    looks_like: str
    """A known mistake, an error, or a clause."""
    rule: str
    """The rulebook's rule, or ""."""
    failures: tuple[Failure, ...]
    """The failed cases: those of the strongest kind first, and of these the smallest one."""
    known: bool = False
    """True if an arbiter with a known mistake fails these cases."""

    @property
    def weakness(self) -> int:
        """Place of the strongest kind of its failures: 0 for wrong grants."""
        return _WEAKNESS[self.failures[0].kind]


def diagnose(results: Sequence[Result], compared: Compared) -> tuple[Diagnosis, ...]:
    """Return diagnoses that contain each failure once: known mistakes, errors and unreadable answers, and clauses.

    In each of these three groups, wrong grants come before wrong verdicts and those before wrong evidence. Then known
    mistakes are in the order of their table, and of the others the one with the most failures comes first.
    """
    found = [result.failure for result in results if result.failure is not None]
    unreadable: dict[tuple[str, str], list[Failure]] = {}
    judged = {}
    for failure in sorted(found, key=lambda one: (_WEAKNESS[one.kind], one.case.size + bool(one.variation))):
        difference = failure.differences[0]
        if isinstance(difference, NoRuling):
            unreadable.setdefault((difference.looks_like, difference.rule), []).append(failure)
        else:
            judged[failure.case.id] = failure
    passed = {result.case.id for result in results if result.played and result.failure is None}
    diagnoses = _known(judged, passed, compared)
    explained = {failure.case.id for diagnosis in diagnoses for failure in diagnosis.failures}
    by_clause: dict[tuple[str, str], list[Failure]] = {}
    for id_, failure in judged.items():
        if id_ not in explained:
            by_clause.setdefault((failure.case.clauses[0], ""), []).append(failure)
    for groups in (unreadable, by_clause):
        others = [Diagnosis(*cause, tuple(group)) for cause, group in groups.items()]
        diagnoses += sorted(others, key=lambda one: (one.weakness, -len(one.failures)))
    return tuple(diagnoses)


def _known(failed: Mapping[str, Failure], passed: set[str], compared: Compared) -> list[Diagnosis]:
    """Return the mistakes that explain the most failures, less the cases that contradict them, one after the other.

    A case contradicts a mistake that fails it if it passed, or if it failed by a weaker kind of difference.
    """
    fitting = []
    for mistake in known_mistakes():
        kinds = mistake.kinds(compared)
        explained = {id_ for id_, kind in kinds.items() if id_ in failed and failed[id_].kind == kind}
        weaker = {id_ for id_, kind in kinds.items() if id_ in failed and _WEAKNESS[failed[id_].kind] > _WEAKNESS[kind]}
        contradicted = len(weaker) + len(kinds.keys() & passed)
        if contradicted <= _TOLERATED * len(explained):
            fitting.append((mistake, explained, contradicted))
    left, found = set(failed), dict[str, Diagnosis]()
    while fitting:
        mistake, ids, contradicted = max(fitting, key=lambda fit: len(fit[1] & left) - fit[2])
        new = ids & left
        if len(new) <= contradicted:
            break
        failures = tuple(failed[id_] for id_ in failed if id_ in new)
        found[mistake.looks_like] = Diagnosis(mistake.looks_like, mistake.rule, failures, known=True)
        left -= new
    in_table_order = [found[mistake.looks_like] for mistake, *_ in fitting if mistake.looks_like in found]
    return sorted(in_table_order, key=lambda one: one.weakness)


def wrapped(text: str, indent: str = "", max_lines: int | None = None) -> str:
    """Return a text in lines of at most 80 characters, all but the first indented by two more; `max_lines` cuts it."""
    return textwrap.fill(
        text,
        80,
        initial_indent=indent,
        subsequent_indent=f"{indent}  ",
        break_on_hyphens=False,
        max_lines=max_lines,
        placeholder=" ...",
    )


def _position(case: ArbiterCase) -> str:
    """Return the places of hunters and targets, and the arguments that differ from the defaults."""
    hunters = [f"hunter {seat} at ({x}, {y})" for seat, (x, y) in enumerate(case.hunters)]
    targets = [f"{shortened(name)} at ({x}, {y})" for name, (x, y) in case.targets.items()]
    given = case.arguments()
    unusual = [f"{key} = {given[key]!r}" for key in case.unusual]
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
