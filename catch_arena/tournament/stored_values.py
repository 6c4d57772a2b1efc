"""A store's rows become objects here, and each value is checked: the file may be damaged, or made by anybody.

Sizes are bounded by what a tournament can hold, so that no number of a stranger's asks for all of the memory.
"""

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from typing import Any, Final, TypeVar, get_args

from catch_arena.config import RULESET, ArenaConfig, Control
from catch_arena.errors import CatchArenaError, ConfigError
from catch_arena.seeding import SEED_LIMIT
from catch_arena.text import LONGEST_NAME, in_short, name_fault, one_line, printable
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import Forfeit, Match, MatchResult, MoveTimes, PlayedMatch
from catch_arena.tournament.players import ForfeitCode
from catch_arena.tournament.secret import Secret
from catch_arena.verdicts import Verdict

RESULTS: Final = tuple(field.name for field in fields(MatchResult) if field.name != "logs")
"""The parts of a result that a store keeps, in their order."""
_MOST: Final = 10**6
"""Of whatever is counted in a match, and entrants."""
_MOST_STEPS: Final = 10**7
_MOST_BLOCKS: Final = 10**12
_LONGEST_S: Final = 1e9
_LONGEST_TEXT: Final = 200
_LONGEST_PATH: Final = 1 << 16
_ID: Final = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,99}")
"""A match's id is a part of a file's name."""
_DIGITS: Final = re.compile(r"[0-9a-f]{0,64}")

_CODES: Final = get_args(ForfeitCode)

T = TypeVar("T")


class DamagedError(Exception):
    """A value that nobody here has written; the text says which, and what it must be."""


def parsed(what: str, text: object) -> Any:
    """A column's JSON.

    Raises:
        DamagedError: where it is none.
    """
    try:
        return _decoded(text_of(what, text, most=None))
    except (ValueError, RecursionError) as error:
        raise DamagedError(f"{what} must be JSON: {error}") from None


def facts_of(rows: Iterable[Sequence[Any]]) -> dict[str, Any]:
    """What a store says of its tournament, by name.

    Raises:
        DamagedError: where that cannot be, or is of another ruleset.
    """
    facts = {text_of("a fact's name", name): parsed("a fact", value) for name, value in rows}
    for name in ("ruleset", "config", "entrants", "plan", "seed", "terms"):
        if name not in facts:
            raise DamagedError(f"{name} is missing")
    if facts["ruleset"] != RULESET:
        raise DamagedError(f"it was played under ruleset {in_short(facts['ruleset'])}, and this is {RULESET}")
    return facts


def config_of(facts: Mapping[str, Any]) -> ArenaConfig:
    """The arena's settings.

    Raises:
        DamagedError: where no arena can have them.
    """
    try:
        return ArenaConfig.from_dict(_table("config", facts["config"]))
    except (CatchArenaError, TypeError, ValueError, AttributeError, RecursionError) as error:
        raise DamagedError(f"config cannot be used: {error}") from None


def entrants_of(facts: Mapping[str, Any]) -> tuple[Entrant, ...]:
    """Who plays; there is at least one, and each has a name of its own.

    Raises:
        DamagedError: where that is not so.
    """
    entrants = tuple(map(_entrant, _list_of("entrants", facts["entrants"], 1, _MOST)))
    if len({one.name for one in entrants}) < len(entrants):
        raise DamagedError("entrants must have a name each")
    return entrants


def parameters_of(what: str, facts: Mapping[str, Any]) -> dict[str, Any]:
    """The plan's parameters, or the terms.

    Raises:
        DamagedError: for a name or a value that neither can have.
    """
    found = _table(what, facts[what])
    for name, value in found.items():
        text_of(f"a name of {what}", name)
        if isinstance(value, str):
            text_of(f"{what}.{name}", value)
        elif isinstance(value, float):
            number_of(f"{what}.{name}", value, -_LONGEST_S, _LONGEST_S)
        elif not isinstance(value, bool):
            whole(f"{what}.{name}", value, -SEED_LIMIT, SEED_LIMIT)
    return found


def secret_of(facts: Mapping[str, Any]) -> Secret | None:
    """What the plan is drawn from.

    Raises:
        DamagedError: where it is no secret.
    """
    text = facts["seed"]
    try:
        return None if text is None else Secret.parse(text_of("seed", text))
    except ConfigError:
        raise DamagedError("seed must be 32 hexadecimal digits, or a whole number") from None


def versions_of(text: object, known: Iterable[str]) -> dict[str, str]:
    """What played, by version.

    Raises:
        DamagedError: for names other than those `known`, or a version that is no text.
    """
    found = _table("versions", parsed("versions", text), [*known])
    return {name: text_of(f"versions.{name}", value) for name, value in found.items()}


@dataclass(frozen=True, slots=True)
class Rows:
    """How the matches of one tournament are read."""

    parties: int
    seats: int
    entrants: int

    def match(self, row: Sequence[Any]) -> Match:
        """A match of the plan, of its id, block, seed, seating and agents' seeds.

        Raises:
            DamagedError: where one of them cannot be.
        """
        name, block, seed, seating, agent_seeds = row
        if not isinstance(name, str) or not _ID.fullmatch(name):
            raise DamagedError(f"a match's id must be of letters, digits, - and _, got {in_short(name)}")
        with _within(name):
            return Match(
                name,
                whole("block", block, 0, _MOST_BLOCKS),
                whole("seed", seed, 0, SEED_LIMIT - 1),
                self._wholes("seating", parsed("seating", seating), 0, self.entrants - 1),
                self._agent_seeds(parsed("agent_seeds", agent_seeds)),
            )

    def _agent_seeds(self, value: object) -> tuple[int, ...]:
        return () if value == [] else self._wholes("agent_seeds", value, 0, SEED_LIMIT - 1)

    def played(self, row: Sequence[Any]) -> PlayedMatch:
        """A match that was played: as `match` has it, its replay's digest, and RESULTS.

        Raises:
            DamagedError: where one of them cannot be, or two do not belong together.
        """
        *planned, replay = row[: -len(RESULTS)]
        match = self.match(planned)
        with _within(match.id):
            parts = {name: parsed(name, text) for name, text in zip(RESULTS, row[-len(RESULTS) :], strict=True)}
            forfeits = self._by_party("forfeits", parts["forfeits"], _forfeit_code)
            details = self._by_party("details", parts["details"], _forfeit) if parts["details"] != [] else ()
            if details and forfeits != tuple(one and one.code for one in details):
                raise DamagedError("details must be of its forfeits")
            result = MatchResult(
                scores=self._wholes("scores", parts["scores"], 0, _MOST),
                ranks=self._wholes("ranks", parts["ranks"], 1, self.parties),
                verdicts=self._by_party("verdicts", parts["verdicts"], _tally),
                contests_won=self._wholes("contests_won", parts["contests_won"], 0, _MOST),
                contests_lost=self._wholes("contests_lost", parts["contests_lost"], 0, _MOST),
                steps=whole("steps", parts["steps"], 0, _MOST_STEPS),
                digest=_digest("digest", parts["digest"]),
                forfeits=forfeits,
                thinking=self._by_party("thinking", parts["thinking"], _move_times),
                details=details,
                lost_to_mates=self._of_teams("lost_to_mates", parts["lost_to_mates"], self.parties),
                catches=self._of_teams("catches", parts["catches"], self.seats),
            )
            return PlayedMatch(match, result, None if replay is None else _digest("replay", replay))

    def _of_teams(self, what: str, value: object, count: int) -> tuple[int, ...]:
        """So many counts, which are left out where no team has several hunters."""
        if self.seats == self.parties and value == []:
            return ()
        return tuple(whole(what, one, 0, _MOST) for one in _list_of(what, value, count, count))

    def _by_party(self, what: str, value: object, read: Callable[[object], T]) -> tuple[T, ...]:
        return tuple(map(read, _list_of(what, value, self.parties, self.parties)))

    def _wholes(self, what: str, value: object, least: int, most: int) -> tuple[int, ...]:
        found = _list_of(what, value, self.parties, self.parties)
        for one in found:
            whole(what, one, least, most)
        return tuple(found)


def in_order(found: Iterable[T], match_of: Callable[[T], Match], after: str = "") -> Iterator[T]:
    """The same, one after the other.

    Raises:
        DamagedError: where the ids of their matches do not ascend from `after`.
    """
    for one in found:
        match = match_of(one)
        if match.id <= after:
            raise DamagedError(f"match {match.id} must come after {after}")
        after = match.id
        yield one


def whole(what: str, value: object, least: int, most: int) -> int:
    """A whole number in [least, most].

    Raises:
        DamagedError: for anything else.
    """
    if type(value) is not int or not least <= value <= most:
        raise DamagedError(f"{what} must be a whole number from {least} to {most}, got {in_short(value)}")
    return value


def number_of(what: str, value: object, least: float, most: float) -> float:
    """A number in [least, most].

    Raises:
        DamagedError: for anything else.
    """
    if type(value) not in {int, float} or not least <= value <= most:  # type: ignore[operator]
        raise DamagedError(f"{what} must be a number from {least:g} to {most:g}, got {in_short(value)}")
    return value  # type: ignore[return-value]


def text_of(what: str, value: object, most: int | None = _LONGEST_TEXT) -> str:
    """A printable text of at most so many characters; for None any text.

    Raises:
        DamagedError: for anything else.
    """
    if not isinstance(value, str) or (most is not None and (len(value) > most or not value.isprintable())):
        must = "text" if most is None else f"printable text of at most {most} characters"
        raise DamagedError(f"{what} must be {must}, got {in_short(value)}")
    return value


@contextmanager
def _within(match: str) -> Iterator[None]:
    try:
        yield
    except DamagedError as error:
        raise DamagedError(f"match {match}: {error}") from None


def _refuse(constant: str) -> float:
    raise ValueError(f"{constant} is no number")


_decoded: Final = json.JSONDecoder(parse_constant=_refuse).decode


def _table(what: str, value: object, names: Sequence[str] | None = None) -> dict[str, Any]:
    if not isinstance(value, dict) or (names is not None and value.keys() != {*names}):
        must = "a table" if names is None else f"a table of {', '.join(names)}"
        raise DamagedError(f"{what} must be {must}, got {in_short(value)}")
    return value


def _list_of(what: str, value: object, least: int, most: int) -> list[Any]:
    if not isinstance(value, list) or not least <= len(value) <= most:
        must = f"{least}" if least == most else f"{least} to {most}"
        raise DamagedError(f"{what} must be a list of {must}, got {in_short(value)}")
    return value


def _digest(what: str, value: object) -> str:
    if not isinstance(value, str) or not _DIGITS.fullmatch(value):
        raise DamagedError(f"{what} must be of hexadecimal digits, 64 at most, got {in_short(value)}")
    return value


def _entrant(value: object) -> Entrant:
    table = _table("entrant", value, [field.name for field in fields(Entrant) if field.name != "side"])
    name, fault, prey_fault = text_of("entrant: name", table["name"], LONGEST_NAME), table["fault"], table["prey_fault"]
    if not isinstance(table["prey"], bool):
        raise DamagedError(f"entrant: prey must be true or false, got {in_short(table['prey'])}")
    if (wrong := name_fault(name)) is not None:
        raise DamagedError(f"entrant: {wrong}")
    if table["control"] not in get_args(Control):
        raise DamagedError(f"entrant: control must be one of {', '.join(get_args(Control))}")
    spec = text_of("entrant: spec", table["spec"], most=None)
    if len(spec) > _LONGEST_PATH:
        raise DamagedError(f"entrant: spec must be of at most {_LONGEST_PATH} characters, got {len(spec)}")
    return Entrant(
        name,
        printable(spec),
        table["control"],
        _digest("entrant: digest", table["digest"]),
        None if fault is None else one_line(text_of("entrant: fault", fault, most=None)),
        table["prey"],
        None if prey_fault is None else one_line(text_of("entrant: prey_fault", prey_fault, most=None)),
        _digest("entrant: prey_digest", table["prey_digest"]),
    )


def _forfeit_code(value: object) -> Any:
    if value is not None and value not in _CODES:
        raise DamagedError(f"forfeits must be null or one of {', '.join(_CODES)}, got {in_short(value)}")
    return value


def _forfeit(value: object) -> Forfeit | None:
    if value is None:
        return None
    code, step, reason = _list_of("details", value, 3, 3)
    return Forfeit(
        _forfeit_code(code),
        whole("details: step", step, 0, _MOST_STEPS),
        one_line(text_of("details: reason", reason, most=None)),
    )


def _tally(value: object) -> dict[str, int]:
    table = _table("verdicts", value)
    for name, count in table.items():
        if name not in Verdict.__members__:
            raise DamagedError(f"verdicts must be by their names, got {in_short(name)}")
        whole("verdicts", count, 0, _MOST_STEPS)
    return table


def _move_times(value: object) -> MoveTimes:
    moves, total_s, longest_s = _list_of("thinking", value, 3, 3)
    return MoveTimes(
        whole("thinking: moves", moves, 0, _MOST_STEPS),
        number_of("thinking: total_s", total_s, 0.0, _LONGEST_S),
        number_of("thinking: longest_s", longest_s, 0.0, _LONGEST_S),
    )
