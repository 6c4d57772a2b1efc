"""Grades by a spec: matches that an agent plays, thresholds that it must reach, points, and hints by rule.

docs/grading.md has the spec's fields and an example.
"""

import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from itertools import cycle, islice
from pathlib import Path
from typing import Any, Final
from xml.etree import ElementTree as ET

from catch_arena.config import RULESET, ArenaConfig
from catch_arena.errors import CatchArenaError, ConfigError, suggest
from catch_arena.files import read_text, tomllib
from catch_arena.policy import PreyView, Side, player_limits
from catch_arena.scenarios import scenario
from catch_arena.text import printable, printable_lines
from catch_arena.tournament.entrants import NOT_INSTALLED, Entrant
from catch_arena.tournament.isolation.playing import play_entrants
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match import MOST_TIMEOUTS, Forfeit, Match, MatchResult
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.secret import Secret

_MATCHES: Final = 10
_MOST_MATCHES: Final = 10_000
_OFTEN: Final = 0.1
"""The part of an agent's requests that a verdict must have for its hint."""
_LOG_SHOWN: Final = 4000
_KINDS: Final = {"str": "text", "list": "a list", "dict": "a table"}
_HINTS: Final[Mapping[str, str]] = {
    "OUT_OF_REACH": "R5.3: a catch needs less than reach_m between the centres, as they stood when the agent saw them: "
    "ask when target.distance < view.limits.reach_m",
    "GRANTED": "R6.1: only granted catches count: it got what it asked for, and asked too seldom: look for the targets "
    "that it reaches soonest, turning included, and before any rival",
    "LOST_CONTEST": "R5.4: of several hunters in reach the nearest is granted the target: look at view.rivals too",
    "MALFORMED": "R5.2: it named a rank that has no target: view.mask and len(view.targets) say which have",
    "SERVICE_DOWN": "R5.7: the kill service fails at times in this arena: ask again in the next step",
    "KILL_FAILED": "R5.7: the simulator refuses a kill at times in this arena: ask again in the next step",
    "no request": "R4.1, R4.4: it never asked for a target: drive closer than view.limits.reach_m to one",
    "empty view": "R7.2: view.targets and view.rivals may be empty, and were",
    "FORFEIT_TIMEOUT": "`catch-arena docs isolation`, Limits: an action has step_ms, and all actions of a match "
    "together have bank_s more: catch-arena check-agent shows how long its steps take",
    "FORFEIT_ILLEGAL": "R4.1, R4.4: `catch-arena docs agents` has the actions of each control; catch-arena check-agent "
    "shows the view that it failed on",
    "FORFEIT_INIT": "`catch-arena docs agents`: a class Agent with reset(self, seed) and act(self, view): catch-arena "
    "check-agent shows where it fails",
    "late start": "`catch-arena docs isolation`, Limits: its import and reset together have init_s: load what is large "
    "once, and search in act",
    "not installed": "`catch-arena docs agents`, What it may import: Python's own modules, NumPy, and what else is "
    "installed where it plays; it needs no ROS",
}
"""What to read, by what happened."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GradingTest:
    """One `[[test]]` of a spec: some matches, and what must come out; a forfeit fails it."""

    name: str
    scenario: str = "standard"
    settings: Mapping[str, Any] = field(default_factory=dict)
    """Changes of the scenario, as for `--set`."""
    opponents: tuple[str, ...] = ()
    """Agents for the other seats, from the first again where there are more seats."""
    matches: int = _MATCHES
    """How many are played; without a number, as many as the spec says."""
    points: float = 1.0
    min_mean_score: float | None = None
    """Catches in a match in which it hunted; of a team, all its hunters' together."""
    min_win_share: float | None = None
    """Matches won, in [0, 1], on its side; a shared win counts in parts. Those of an only prey are left out."""
    max_mean_refused: float | None = None
    """Requests a match that were refused, lost contests not counted."""
    max_mean_caught: float | None = None
    """How often it was caught, in a match in which it was prey."""
    cases: tuple[str, ...] = ()
    """For a ROS 2 node in place of an agent: cases of the conformance suite, or what their ids begin with."""

    @property
    def config(self) -> ArenaConfig:
        """The arena."""
        return scenario(self.scenario, **self.settings)


@dataclass(frozen=True, slots=True)
class GradingSpec:
    """What an agent is graded by."""

    title: str
    tests: tuple[GradingTest, ...]
    secret: Secret
    """From which the seeds of all matches follow."""
    seed_file: Path | None = None
    """Where its seed was read from, if not from itself."""

    def matches(self, test: GradingTest) -> tuple[Match, ...]:
        """Those of one of the tests, with the student, 0, as each party in turn: each hunter or team, and each prey."""
        secret, parties = self.secret.part("grade", self.tests.index(test)), len(Parties.of(test.config))
        return tuple(
            Match(
                id=f"m{number + 1:05d}",
                block=number,
                seed=secret.seed("match", number),
                seating=(*range(1, number % parties + 1), 0, *range(number % parties + 1, parties)),
                agent_seeds=tuple(secret.seed("agent", number, party) for party in range(parties)),
            )
            for number in range(test.matches)
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class TestGrade:
    """What one test gave, of an agent or of a node."""

    test: str
    points: float
    """Those of the test where nothing failed, else 0."""
    possible: float
    failures: tuple[str, ...]
    hints: tuple[str, ...]
    log: str = ""
    """The last of what was printed."""

    @property
    def measured(self) -> str:
        """The figures, for people."""
        raise NotImplementedError

    def __str__(self) -> str:
        """For people: what was measured, then what failed, then what to read."""
        head = f"{'failed' if self.failures else 'passed'}  {self.points:g}/{self.possible:g}  {self.test}"
        return "\n        ".join(
            [f"{head}: {self.measured}", *self.failures, *(f"hint: {hint}" for hint in self.hints)]
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Grade(TestGrade):
    """What one test gave of an agent; all figures are of the matches that were played."""

    matches: int
    mean_score: float
    win_share: float
    mean_refused: float
    mean_caught: float | None
    """Where it was prey."""
    verdicts: Mapping[str, int]

    @property
    def measured(self) -> str:
        """The figures, for people."""
        caught = "" if self.mean_caught is None else f", caught {self.mean_caught:.2f}"
        return (
            f"{self.matches} matches, score {self.mean_score:.2f}, wins {100 * self.win_share:.0f} %, "
            f"refused {self.mean_refused:.2f}{caught}"
        )


def read_spec(path: Path) -> GradingSpec:
    """The spec in a file.

    Raises:
        ConfigError: one line, that names the field, the requirement and the value.
    """
    try:
        table = tomllib.loads(read_text(path))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: is no TOML: {error}") from None
    try:
        _require_known("spec", table, ("title", "seed", "seed_file", "matches", "test"))
        title = _checked("title", table.get("title", path.stem), str)
        secret = _secret(table, path.parent)
        matches = table.get("matches", _MATCHES)
        tests = tuple(
            _test(f"test[{number}]", test, matches, path.parent)
            for number, test in enumerate(_checked("test", table.get("test", []), list), 1)
        )
        if not tests:
            raise ConfigError("test must be given at least once, as [[test]], got none")
    except CatchArenaError as error:
        raise ConfigError(f"{path}: {error}") from None
    return GradingSpec(title, tests, secret, path.parent / table["seed_file"] if "seed_file" in table else None)


def grade_agent(
    spec: GradingSpec,
    test: GradingTest,
    student: Entrant,
    opponents: Sequence[Entrant],
    sandbox: Sandbox | None,
    max_forfeits: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> Grade:
    """Play the matches of one of a spec's tests, the student in each seat in turn.

    Args:
        spec: the student is graded by.
        test: one of its tests.
        student: who is graded.
        opponents: who plays in the other seats, from the first again if there are more seats.
        sandbox: how agents that are not trusted run.
        max_forfeits: after so many forfeits in a row, and after two time-outs, the rest is not played; 0 for never.
        progress: called with (played, in all) after each match.

    Raises:
        NoContest: where a match could not be held.
    """
    config = test.config
    parties = Parties.of(config)
    others = list(islice(cycle(opponents), len(parties) - 1)) if opponents else []
    others = [replace(one, name=f"{one.name} {number}") for number, one in enumerate(others, 1)]
    played: list[tuple[int, MatchResult]] = []
    forfeited = timeouts = 0
    stopped = ""
    for match in spec.matches(test):
        party = match.seating.index(0)
        seating = [*others[:party], student, *others[party:]]
        result = play_entrants(config, match.seed, seating, sandbox, agent_seeds=match.agent_seeds)
        played.append((party, result))
        if progress is not None:
            progress(len(played), test.matches)
        forfeited = 0 if result.forfeits[party] is None else forfeited + 1
        timeouts += (forfeit := result.details[party]) is not None and forfeit.late
        if max_forfeits and timeouts == MOST_TIMEOUTS:
            stopped = f"it took too long in {timeouts} matches"
        elif max_forfeits and forfeited == max_forfeits:
            stopped = f"it had forfeited {forfeited} matches in a row"
        if stopped:
            break
    return _grade(test, played, parties, stopped)


def _grade(test: GradingTest, played: Sequence[tuple[int, MatchResult]], parties: Parties, stopped: str) -> Grade:
    verdicts: Counter[str] = Counter()
    reasons: dict[str, str] = {}
    causes: list[str] = []
    scores: dict[Side, list[int]] = {"hunter": [], "prey": []}
    wins: list[float] = []
    log = ""
    for party, result in played:
        verdicts.update(result.verdicts[party])
        side = parties.side_of(party)
        scores[side].append(result.scores[party])
        forfeit, rivals = result.details[party], result.ranks[parties.on(side)]
        if len(rivals) > 1 or len(parties.sides) == 1:  # the only prey has nobody to win against
            wins.append(0.0 if forfeit else (result.ranks[party] == 1) / rivals.count(1))
        if forfeit is None:
            continue
        if forfeit.code not in reasons:
            reasons[forfeit.code] = str(forfeit)
            log = log or result.logs[party][-_LOG_SHOWN:]
            causes += _causes_of(forfeit, test.config)
    count = len(played)
    refused = verdicts.total() - verdicts["GRANTED"] - verdicts["LOST_CONTEST"]
    hunted, caught = (sum(own) / len(own) if own else None for own in scores.values())
    win_share = sum(wins) / len(wins) if wins else 0.0
    measured = {"mean_score": hunted or 0.0, "win_share": win_share, "mean_refused": refused / count}
    failures = list(reasons.values())
    if count < test.matches:
        left = test.matches - count
        failures.append(f"FORFEIT_OUT: {stopped}; {left} more were not played")
    for name, value in measured.items():
        least, most = getattr(test, f"min_{name}", None), getattr(test, f"max_{name}", None)
        if least is not None and value < least:
            failures.append(f"{name} must be at least {least:g}, got {value:.4g}")
        if most is not None and value > most:
            failures.append(f"{name} must be at most {most:g}, got {value:.4g}")
    if test.max_mean_caught is not None and caught is not None and caught > test.max_mean_caught:
        failures.append(f"mean_caught must be at most {test.max_mean_caught:g}, got {caught:.4g}")
    if failures:
        often = [name for name, times in verdicts.items() if times > _OFTEN * verdicts.total()]
        causes += [name for name in often if name != "GRANTED"]
        causes += [] if causes else often or ["no request"]
    return Grade(
        test=test.name,
        points=0.0 if failures else test.points,
        possible=test.points,
        matches=count,
        **measured,
        mean_caught=caught,
        verdicts=dict(sorted(verdicts.items())),
        failures=tuple(failures),
        hints=tuple(_HINTS[cause] for cause in causes if cause in _HINTS),
        log=log,
    )


def _causes_of(forfeit: Forfeit, config: ArenaConfig) -> list[str]:
    """Return which hints an agent that forfeited needs."""
    if _misses_a_module(forfeit):
        return ["not installed"]
    if forfeit.late and forfeit.code == "FORFEIT_INIT":
        return ["late start"]
    if forfeit.code != "FORFEIT_CRASH" or forfeit.observation is None:
        return [forfeit.code]
    view = player_limits(config, forfeit.seat).view(*forfeit.observation)
    seen = (view.hunters, view.others) if isinstance(view, PreyView) else (view.targets, view.rivals)
    return [forfeit.code] if all(seen) else ["empty view"]


def _misses_a_module(forfeit: Forfeit) -> bool:
    return NOT_INSTALLED in forfeit.reason or ModuleNotFoundError.__name__ in forfeit.reason


def json_text(spec: GradingSpec, name: str, digest: str | None, grades: Sequence[TestGrade]) -> str:
    """The grades as JSON; no seed is told.

    Args:
        spec: by which it was graded.
        name: the agent's, or the node's.
        digest: of the agent's files; a node has none.
        grades: of the spec's tests.
    """
    content = {
        "title": spec.title,
        "agent": name,
        "digest": digest,
        "ruleset": RULESET,
        "points": sum((one.points for one in grades), 0.0),
        "possible": sum((one.possible for one in grades), 0.0),
        "tests": [asdict(one) for one in grades],
    }
    return json.dumps(content, indent=2) + "\n"


def junit_text(spec: GradingSpec, name: str, grades: Sequence[TestGrade]) -> str:
    """The grades as JUnit XML, a test case for each test; no seed is told."""
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
    """Which matches a spec has, as JSON, with all their seeds: for nobody who may be graded by it again."""
    content = {
        "title": spec.title,
        "seed": spec.secret.digits,
        "tests": [
            {
                "test": test.name,
                "matches": [
                    {"seat": match.seating.index(0), "seed": match.seed, "agent_seeds": match.agent_seeds}
                    for match in spec.matches(test)
                ],
            }
            for test in spec.tests
        ],
    }
    return json.dumps(content, indent=2) + "\n"


def _test(at: str, table: Any, matches: Any, folder: Path) -> GradingTest:
    _checked(at, table, dict)
    _require_known(at, table, [one.name for one in fields(GradingTest)])
    for name in ("name", "scenario"):
        _checked(f"{at}.{name}", table.get(name, "" if name == "name" else "standard"), str)
    if not table.get("name"):
        raise ConfigError(f"{at}.name must be given")
    thresholds = {"min_mean_score": 1e6, "min_win_share": 1.0, "max_mean_refused": 1e6, "max_mean_caught": 1e6}
    for name, most in {"points": 1e6, **thresholds}.items():
        value = table.get(name, 0.0)
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value <= most:
            raise ConfigError(f"{at}.{name} must be a number from 0 to {most:g}, got {value!r}")
    opponents = _checked(f"{at}.opponents", table.get("opponents", []), list)
    for word in opponents:
        _checked(f"{at}.opponents", word, str)
    cases = _checked(f"{at}.cases", table.get("cases", []), list)
    for word in cases:
        _checked(f"{at}.cases", word, str)
    if cases:
        if rest := sorted(table.keys() - {"name", "points", "cases"}):
            raise ConfigError(f"{at}.{rest[0]} must be left out beside cases, which are asked of a node")
        return GradingTest(name=table["name"], points=float(table.get("points", 1)), cases=tuple(cases))
    own = table.get("matches", matches)
    if isinstance(own, bool) or not isinstance(own, int) or not 1 <= own <= _MOST_MATCHES:
        where = f"{at}.matches" if "matches" in table else "matches"
        raise ConfigError(f"{where} must be a whole number from 1 to {_MOST_MATCHES}, got {own!r}")
    settings = _checked(f"{at}.settings", table.get("settings", {}), dict)
    if "control" in settings:
        raise ConfigError(f"{at}.settings.control must be left to the agents: each states its own control")
    # files stand beside the spec, as its seed_file does
    words = tuple(str(folder / Path(word).expanduser()) if word.endswith(".py") else word for word in opponents)
    test = GradingTest(**{**table, "opponents": words, "matches": own, "points": float(table.get("points", 1))})
    try:
        config = test.config
    except ConfigError as error:
        raise ConfigError(f"{at}: {error}") from None
    parties = len(Parties.of(config))
    if test.max_mean_caught is not None and (not config.prey or own < parties):
        need = f"of at least {parties} matches, so that it is prey in one" if config.prey else "of a scenario with prey"
        raise ConfigError(f"{at}.max_mean_caught must be {need}, got {own if config.prey else test.scenario!r}")
    if parties > 1 and not opponents:
        empty = parties - 1
        seats = "1 seat is" if empty == 1 else f"{empty} seats are"
        raise ConfigError(f'{at} needs opponents: {seats} empty; name agents, as in opponents = ["nearest"]')
    return test


def _secret(table: Mapping[str, Any], folder: Path) -> Secret:
    """The spec's; a fresh one where it has none."""
    if "seed" in table and "seed_file" in table:
        raise ConfigError("seed and seed_file must not both be given")
    if "seed_file" in table:
        path = folder / _checked("seed_file", table["seed_file"], str)
        try:
            text = read_text(path)
        except OSError as error:
            raise ConfigError(f"seed_file must be a file: {error}") from None
        try:
            return Secret.parse(text.strip())
        except ConfigError:  # which would show what is to be hidden
            raise ConfigError(f"seed_file must hold 32 hexadecimal digits or a number, and {path} does not") from None
    seed = table.get("seed")
    return Secret.parse(seed) if isinstance(seed, str) else Secret.of(seed)


def _checked(at: str, value: Any, kind: type) -> Any:
    if not isinstance(value, kind):
        raise ConfigError(f"{at} must be {_KINDS[kind.__name__]}, got {value!r}")
    return value


def _require_known(at: str, table: Mapping[str, Any], known: Sequence[str]) -> None:
    for name in table:
        if name not in known:
            raise ConfigError(f"unknown field {at}.{name}: {suggest(name, known)}")
