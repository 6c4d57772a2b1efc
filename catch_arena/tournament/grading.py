"""Grading of an agent by a spec: it plays the matches of each test, and gets points, or failures with fixed hints."""

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from io import BytesIO
from itertools import cycle, islice
from statistics import fmean
from typing import Any, Final, NamedTuple
from xml.etree import ElementTree as ET

from catch_arena.config import RULESET, ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.files import tomllib
from catch_arena.policy import PreyView, Side, View, player_limits
from catch_arena.text import last_lines, printable, printable_lines
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.grading_spec import GradingSpec, GradingTest
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.loading import NOT_INSTALLED
from catch_arena.tournament.match import MAX_FORFEITS, MOST_TIMEOUTS, Forfeit, MatchResult
from catch_arena.tournament.match_loop import play_entrants
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.players import enter

_OFTEN: Final = 0.1
"""Share of an agent's requests, in [0, 1], that a verdict must exceed for its hint."""
_LONGEST_NAME: Final = 180
"""Largest part of a test's name in a replay's title, which has at most 200 printable characters."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TestGrade:
    """Result of one test, of an agent or of a node."""

    test: str
    points: float
    """Points of the test if nothing failed, else 0."""
    possible: float
    failures: tuple[str, ...]
    """Failures in words, each with the bound that was missed."""
    hints: tuple[str, ...]
    figures: Mapping[str, Any]
    measured: str
    """Figures in words."""
    log: str = ""
    """End of the printed text."""

    def __str__(self) -> str:
        """Return the figures, then the failures, then the hints."""
        head = f"{'failed' if self.failures else 'passed'}  {self.points:g}/{self.possible:g}  {self.test}"
        lines = f"{head}: {self.measured}", *self.failures, *(f"hint: {hint}" for hint in self.hints)
        return "\n        ".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Return the grade as a dictionary for JSON."""
        known = ("test", "points", "possible", "failures", "hints", "log")
        return {name: getattr(self, name) for name in known} | dict(self.figures)


class GradedMatch(NamedTuple):
    """Match of a test."""

    party: int
    """Party of the graded agent."""
    result: MatchResult
    replay: bytes


def enter_opponents(spec: GradingSpec, sandbox: Sandbox | None) -> list[tuple[Entrant, ...]]:
    """Return the opponents in each test of a spec; raise ConfigError if one cannot play, or if only a node can."""
    entered = []
    for test in spec.tests:
        at = f"{spec.path}: {test.name}"
        if test.cases:
            raise ConfigError(f"{at}: only a node can play cases; give its service, such as ros:/catch_turtle")
        opponents = enter(test.opponents, sandbox)
        for opponent_spec, opponent in zip(test.opponents, opponents, strict=True):
            if opponent.fault is not None:
                raise ConfigError(f"{at}: opponent {opponent_spec} cannot play: {opponent.fault}")
        entered.append(opponents)
    return entered


def unplayed_grade(test: GradingTest, fault: str, *, hinted: bool = True) -> TestGrade:
    """Return the grade of an agent that cannot begin: no match is played."""
    forfeit = Forfeit("FORFEIT_INIT", 0, fault)
    return TestGrade(
        test=test.name,
        points=0.0,
        possible=test.points,
        failures=(str(forfeit) if hinted else fault,),
        hints=_hints(_causes_of(forfeit, test.config)) if hinted else (),
        figures={},
        measured="not played",
    )


def grade_agent(
    spec: GradingSpec,
    test: GradingTest,
    student: Entrant,
    opponents: Sequence[Entrant],
    sandbox: Sandbox | None,
    progress: Callable[[int, int], None] = lambda *_: None,
    play: Callable[..., MatchResult] = play_entrants,
) -> tuple[TestGrade, list[GradedMatch]]:
    """Play the matches of a test, with the student's agent in each seat in turn, and return its grade and the matches.

    After two timeouts, or MAX_FORFEITS forfeits in a row, the rest is not played. `progress` is called with
    (played, total) matches after each match, and `play` as `play_entrants`.
    """
    config, matches = test.config, spec.matches(test)
    parties = Parties.of(config)
    others = list(islice(cycle(opponents), len(parties) - 1)) if opponents else []
    if len(others) > 1:
        others = [replace(one, name=f"{one.name} {number}") for number, one in enumerate(others, 1)]
    played: list[GradedMatch] = []
    forfeited = timeouts = 0
    stopped = ""
    for match in matches:
        party = match.seating.index(0)
        seating = [*others[:party], student, *others[party:]]
        replay, title = BytesIO(), f"{printable(test.name)[:_LONGEST_NAME]}, match {match.block + 1}"
        result = play(config, match.seed, seating, sandbox, agent_seeds=match.agent_seeds, title=title, record=replay)
        played.append(GradedMatch(party, result, replay.getvalue()))
        progress(len(played), len(matches))
        forfeit = result.forfeits[party]
        forfeited = 0 if forfeit is None else forfeited + 1
        timeouts += forfeit is not None and forfeit.late
        if timeouts == MOST_TIMEOUTS or forfeited == MAX_FORFEITS:
            slow = timeouts == MOST_TIMEOUTS
            why = f"took too long in {timeouts} matches" if slow else f"had forfeited {forfeited} matches in a row"
            left = len(matches) - len(played)
            stopped = f"FORFEIT_OUT: it {why}; {left} more were not played" if left else ""
            break
    return _grade(test, played, parties, stopped), played


def _grade(test: GradingTest, played: Sequence[GradedMatch], parties: Parties, stopped: str) -> TestGrade:
    verdicts: Counter[str] = Counter()
    forfeits: dict[str, Forfeit] = {}  # the first of each code
    scores: dict[Side, list[int]] = {"hunter": [], "prey": []}
    wins: list[float] = []
    log = ""
    for party, result, _ in played:
        verdicts.update(result.verdicts[party])
        side = parties.side_of(party)
        scores[side].append(result.scores[party])
        forfeit, cut = result.forfeits[party], parties.on(side)
        if len(result.ranks[cut]) > 1 or len(parties.sides) == 1:  # an only prey has no other prey to win against
            wins.append(result.win_share(party, cut))
        if forfeit is not None and forfeit.code not in forfeits:
            forfeits[forfeit.code] = forfeit
            log = log or last_lines(result.logs[party])
    refused = verdicts.total() - verdicts["GRANTED"] - verdicts["LOST_CONTEST"]
    figures: dict[str, Any] = {
        "matches": len(played),
        "mean_score": fmean(scores["hunter"] or [0.0]),
        "win_share": fmean(wins or [0.0]),
        "mean_refused": refused / len(played),
        "mean_caught": fmean(scores["prey"]) if scores["prey"] else None,
        "verdicts": dict(sorted(verdicts.items())),
    }
    failures = [*map(str, forfeits.values()), *([stopped] if stopped else []), *_missed_bounds(test, figures)]
    counted = "1 match" if len(played) == 1 else f"{len(played)} matches"
    contested = any(len(parties.seats[parties.on(side)]) > 1 for side in parties.sides)
    won = f", wins {100 * figures['win_share']:.0f} %" if contested else ""
    caught = "" if figures["mean_caught"] is None else f", caught {figures['mean_caught']:.2f}"
    return TestGrade(
        test=test.name,
        points=0.0 if failures else test.points,
        possible=test.points,
        failures=tuple(failures),
        hints=_hints(_causes(forfeits.values(), verdicts, test.config)) if failures else (),
        figures=figures,
        measured=f"{counted}, score {figures['mean_score']:.2f}{won}, refused {figures['mean_refused']:.2f}{caught}",
        log=log,
    )


def _missed_bounds(test: GradingTest, figures: Mapping[str, Any]) -> Iterator[str]:
    """Yield the missed thresholds, in words."""
    for name, value in figures.items():
        least, most = getattr(test, f"min_{name}", None), getattr(test, f"max_{name}", None)
        if least is not None and value < least:
            yield f"{name} must be at least {least:g}, got {value:.4g}"
        if most is not None and value is not None and value > most:
            yield f"{name} must be at most {most:g}, got {value:.4g}"


def _hints(causes: Iterable[str]) -> tuple[str, ...]:
    """Return the hints for these causes; some verdicts have none."""
    hints = tomllib.loads((files("catch_arena.tournament") / "hints.toml").read_text(encoding="utf-8"))
    return tuple(hints[cause] for cause in causes if cause in hints)


def _causes(forfeits: Iterable[Forfeit], verdicts: Counter[str], config: ArenaConfig) -> list[str]:
    """Return the causes of a failure: those of each forfeit, and frequent verdicts on the agent's requests."""
    often = [name for name, times in verdicts.items() if times > _OFTEN * verdicts.total()]
    causes = [cause for one in forfeits for cause in _causes_of(one, config)]
    causes += [name for name in often if name != "GRANTED"]
    return causes or often or ["no request"]


def _causes_of(forfeit: Forfeit, config: ArenaConfig) -> list[str]:
    """Return the causes of a forfeit, as hints.toml names them."""
    if NOT_INSTALLED in forfeit.reason or ModuleNotFoundError.__name__ in forfeit.reason:
        return ["not installed"]
    if forfeit.late and forfeit.code == "FORFEIT_INIT":
        return ["late start"]
    if forfeit.reason.endswith("(file_mib)"):
        return ["printed too much"]
    if forfeit.code == "FORFEIT_CRASH" and forfeit.observation is not None:
        return _empty_lists(player_limits(config, forfeit.seat).view(*forfeit.observation)) or [forfeit.code]
    return [forfeit.code]


def _empty_lists(view: View | PreyView) -> list[str]:
    """Return causes: lists of a view that were empty, although the arena has something for them."""
    if isinstance(view, PreyView):
        empty = {"hunters": not view.hunters, "others": not view.others and view.limits.prey_seen > 0}
    else:
        empty = {"targets": not view.targets, "rivals": not view.rivals and view.limits.hunters_seen > 0}
    return [f"no {name}" for name, is_empty in empty.items() if is_empty]


def json_text(spec: GradingSpec, name: str, digest: str | None, grades: Sequence[TestGrade]) -> str:
    """Return the grades of an agent, or of a node, which has no digest, as JSON without seeds."""
    content = {
        "title": spec.title,
        "agent": name,
        "digest": digest,
        "ruleset": RULESET,
        "points": sum((one.points for one in grades), 0.0),
        "possible": sum((one.possible for one in grades), 0.0),
        "tests": [one.to_dict() for one in grades],
    }
    return json.dumps(content, indent=2) + "\n"


def junit_text(spec: GradingSpec, name: str, grades: Sequence[TestGrade]) -> str:
    """Return the grades as JUnit XML, a test case for each test, without seeds."""
    failed = sum(bool(one.failures) for one in grades)
    suite = ET.Element(
        "testsuite", name=printable(spec.title), tests=str(len(grades)), failures=str(failed), errors="0"
    )
    properties = ET.SubElement(suite, "properties")
    for what in ("points", "possible"):
        total = sum(getattr(one, what) for one in grades)
        ET.SubElement(properties, "property", name=what, value=f"{total:g}")
    for one in grades:
        case = ET.SubElement(suite, "testcase", classname=name, name=printable(one.test))
        if one.failures:
            failure = ET.SubElement(case, "failure", message=printable(one.failures[0]))
            failure.text = printable_lines("\n".join([*one.failures, *one.hints]))
        if one.log:
            ET.SubElement(case, "system-out").text = printable_lines(one.log)
    ET.indent(suite)
    return f'<?xml version="1.0" encoding="utf-8"?>\n{ET.tostring(suite, encoding="unicode")}\n'


def seeds_text(spec: GradingSpec) -> str:
    """Return the matches of a spec as JSON, with all seeds; keep them secret while the spec is in use."""
    content = {
        "title": spec.title,
        "seed": spec.secret.digits,
        "tests": [
            {
                "test": test.name,
                "matches": [
                    {"party": match.seating.index(0), "seed": match.seed, "agent_seeds": match.agent_seeds}
                    for match in spec.matches(test)
                ],
            }
            for test in spec.tests
        ],
    }
    return json.dumps(content, indent=2) + "\n"
