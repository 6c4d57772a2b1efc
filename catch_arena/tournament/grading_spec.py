"""Grading specs: TOML files with matches that an agent plays, thresholds that it must reach, and points.

docs/howto/grading.md has the spec's fields and an example.
"""

import os
import re
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final

import msgspec
from msgspec import Meta

from catch_arena.config import ArenaConfig
from catch_arena.errors import CatchArenaError, ConfigError, suggest
from catch_arena.files import read_text, tomllib
from catch_arena.scenarios import scenario
from catch_arena.tournament.agent_spec import IN_FOLDER, shipped_names
from catch_arena.tournament.match import Match
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.secret import Secret

Count = Annotated[int, Meta(ge=1, le=10_000)]
Share = Annotated[float, Meta(ge=0.0, le=1.0)]
Amount = Annotated[float, Meta(ge=0.0, le=1e6)]

_KINDS: Final = {"str": "text", "array": "a list", "object": "a table", "int": "a whole number", "float": "a number"}
"""Names of types for errors, by msgspec's names."""


class GradingTest(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Test of a spec (`[[test]]`): matches, and thresholds. A forfeit fails the test."""

    name: Annotated[str, Meta(min_length=1)]
    scenario: str = "standard"
    settings: dict[str, Any] = {}
    """Changes of the scenario, as for `--set`."""
    opponents: tuple[str, ...] = ()
    """Agents for the other seats, from the first again if there are more seats."""
    matches: Count | None = None
    """Number of matches; None only until `read_spec` has taken the spec's own."""
    points: Amount = 1.0
    min_mean_score: Amount | None = None
    """Smallest mean of its catches per match as a hunter; for a team, of all its hunters in total."""
    min_win_share: Share | None = None
    """Smallest share of matches won on its side, in [0, 1]; a shared win counts in parts. Matches as the only prey do
    not count.
    """
    max_mean_refused: Amount | None = None
    """Largest mean of refused requests per match, without lost contests."""
    max_mean_caught: Amount | None = None
    """Largest mean number of times that it was caught per match as prey."""
    cases: tuple[str, ...] = ()
    """Cases of the conformance suite for a ROS 2 node instead of an agent: their ids, or beginnings of ids."""

    @property
    def config(self) -> ArenaConfig:
        """Settings of the arena."""
        return scenario(self.scenario, **self.settings)


class _File(msgspec.Struct, kw_only=True, forbid_unknown_fields=True):
    """Fields of a spec's file."""

    title: str | None = None
    seed: str | int | None = None
    seed_file: str | None = None
    matches: Count = 10
    launch: str = ""
    test: Annotated[tuple[GradingTest, ...], Meta(min_length=1)]


@dataclass(frozen=True, slots=True)
class GradingSpec:
    """Grading spec: the tests by which an agent is graded."""

    path: Path
    title: str
    tests: tuple[GradingTest, ...]
    secret: Secret
    """Source of the seeds of all matches."""
    has_seed: bool = True
    """False if the seed is drawn in each run."""
    launch: str = ""
    """Command that starts a student's ROS 2 node in the student's folder, for `grade FOLDER --ros`."""

    def matches(self, test: GradingTest) -> tuple[Match, ...]:
        """Return the matches of a test, with the student (0) as each party in turn: a hunter or team, or a prey."""
        secret, parties = self.secret.part("grade", self.tests.index(test)), len(Parties.of(test.config))
        return tuple(
            Match(
                id=f"m{number + 1:05d}",
                block=number,
                seed=secret.seed("match", number),
                seating=(*range(1, number % parties + 1), 0, *range(number % parties + 1, parties)),
                agent_seeds=tuple(secret.seed("agent", number, party) for party in range(parties)),
            )
            for number in range(test.matches or 0)
        )


def read_spec(path: Path) -> GradingSpec:
    """Return the spec in a file, or raise ConfigError in one line with the field, the requirement and the value."""
    try:
        table = tomllib.loads(read_text(path))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: is no TOML: {error}") from None
    try:
        file = msgspec.convert(table, _File)
        secret = _secret(file, path.parent)
        tests = tuple(
            _complete(f"test[{number}]", test, given, file.matches, path.parent)
            for number, (test, given) in enumerate(zip(file.test, table["test"], strict=True), 1)
        )
    except msgspec.ValidationError as error:
        raise ConfigError(f"{path}: {_describe(str(error), table)}") from None
    except CatchArenaError as error:
        raise ConfigError(f"{path}: {error}") from None
    has_seed = not (file.seed is None and file.seed_file is None)
    title = path.stem if file.title is None else file.title
    return GradingSpec(path, title, tests, secret, has_seed, file.launch)


def _complete(at: str, test: GradingTest, given: Collection[str], matches: int, folder: Path) -> GradingTest:
    """Return a test with its number of matches, and the paths of its opponents; check that its fields fit together."""
    if test.cases:
        if rest := sorted({*given} - {"name", "points", "cases"}):
            raise ConfigError(f"{at}.{rest[0]} must be left out beside cases, which are asked of a node")
        return test
    if "control" in test.settings:
        raise ConfigError(f"{at}.settings.control must be left to the agents: each states its own control")
    try:
        config = test.config
    except ConfigError as error:
        raise ConfigError(f"{at}: {error}") from None
    parties, played = len(Parties.of(config)), test.matches or matches
    if test.max_mean_caught is not None and not config.prey:
        raise ConfigError(f"{at}.max_mean_caught must be of a scenario with prey, got {test.scenario!r}")
    if test.max_mean_caught is not None and played < parties:
        need = f"of at least {parties} matches, so that it is prey in one"
        raise ConfigError(f"{at}.max_mean_caught must be {need}, got {played}")
    if parties > 1 and not test.opponents:
        seats = "1 seat is" if parties == 2 else f"{parties - 1} seats are"
        raise ConfigError(f'{at} needs opponents: {seats} empty; name agents, as in opponents = ["nearest"]')
    opponents = tuple(_from(folder, word) for word in test.opponents)
    return msgspec.structs.replace(test, opponents=opponents, matches=played)


def _from(folder: Path, word: str) -> str:
    """Return an opponent; the path of a file or folder is relative to the spec's folder, as for its seed_file."""
    path = folder / os.path.expanduser(word)
    is_folder = (path / IN_FOLDER).is_file() and word not in shipped_names()
    return str(path) if is_folder or word.endswith(".py") else word


def _secret(file: _File, folder: Path) -> Secret:
    """Return the spec's secret, or a new one if it has none; raise ConfigError for two seeds, or an invalid one."""
    if file.seed is not None and file.seed_file is not None:
        raise ConfigError("seed and seed_file must not both be given")
    if file.seed_file is None:
        return Secret.parse(file.seed) if isinstance(file.seed, str) else Secret.of(file.seed)
    path = folder / file.seed_file
    try:
        text = read_text(path)
    except OSError as error:
        raise ConfigError(f"seed_file must be a file: {error}") from None
    try:
        return Secret.parse(text.strip())
    except ConfigError:  # its message would show the secret
        raise ConfigError(f"seed_file must hold 32 hexadecimal digits or a number, and {path} does not") from None


def _describe(message: str, table: Any) -> str:
    """Return msgspec's message about a table as `test[1].points must be a number >= 0.0, got -1`."""
    problem, _, path = message.partition(" - at ")
    at, value = "", table
    for name, index in re.findall(r"\.(\w+)|\[(\d+)\]", path):
        at += f"[{int(index) + 1}]" if index else f".{name}"
        value = value[int(index) if index else name]
    at = at.removeprefix(".") or "spec"
    if field := re.fullmatch(r"Object contains unknown field `(.*)`", problem):
        known = (_File if at == "spec" else GradingTest).__struct_fields__
        return f"unknown field {at}.{field[1]}: {suggest(field[1], known)}"
    if field := re.fullmatch("Object missing required field `(.*)`", problem):
        return f"{at}.{field[1]} must be given" if at != "spec" else f"at least one [[{field[1]}]] must be given"
    wanted = problem.removeprefix("Expected ").partition(", got")[0].replace("`", "").replace(" | null", "")
    wanted = re.sub(r"\w+", lambda kind: _KINDS.get(kind[0], kind[0]), wanted.replace(" | ", " or "))
    return f"{at} must be {wanted}, got {value!r}"
