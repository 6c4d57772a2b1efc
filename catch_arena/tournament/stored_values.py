"""Rows of a store as objects: msgspec decodes each value and checks its type."""

from collections.abc import Iterable, Sequence
from typing import Any, Final, TypeVar, get_type_hints

import msgspec

from catch_arena.config import RULESET, ArenaConfig
from catch_arena.errors import CatchArenaError
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import Match, MatchResult, PlayedMatch
from catch_arena.tournament.secret import Secret

_DECODERS: Final = {
    name: msgspec.json.Decoder(kind) for name, kind in get_type_hints(MatchResult).items() if name != "logs"
}
RESULTS: Final = tuple(_DECODERS)
"""The parts of a result that a store keeps, in their order; each is a column with JSON."""
_BY_PARTY: Final = ("scores", "ranks", "verdicts", "contests_won", "contests_lost", "forfeits", "thinking")
_INDICES: Final = msgspec.json.Decoder(tuple[int, ...])
_VERSIONS: Final = msgspec.json.Decoder(dict[str, str])
_ANY: Final = msgspec.json.Decoder()
_MATCH_ROW: Final = tuple[str, int, int, str, str]

T = TypeVar("T")


class DamagedError(Exception):
    """A value that no command has written; the text names the table, the row and the value."""


class Facts(msgspec.Struct):
    """Table `fact`, by name."""

    ruleset: str
    config: dict[str, Any]
    entrants: tuple[Entrant, ...]
    plan: dict[str, str | int | float]
    seed: str | None
    terms: dict[str, str | int | float | bool]
    ended: bool = False


def facts_of(rows: Iterable[Sequence[Any]]) -> Facts:
    """Return the facts of a tournament.

    Raises:
        DamagedError: if one is missing or damaged, or of another ruleset.
    """
    values = {str(name): _decode(_ANY, "fact", name, "value", value) for name, value in rows}
    if values.get("ruleset", RULESET) != RULESET:
        raise DamagedError(f"it was played under ruleset {values['ruleset']}, and this is {RULESET}")
    try:
        return msgspec.convert(values, Facts)
    except msgspec.ValidationError as error:  # it names the row
        raise DamagedError(f"table fact: {error}") from None


def config_of(facts: Facts) -> ArenaConfig:
    """Return the arena's settings.

    Raises:
        DamagedError: if no arena can have them.
    """
    try:
        return ArenaConfig.from_dict(facts.config)
    except (CatchArenaError, TypeError, ValueError) as error:
        raise DamagedError(f"table fact, row config: {error}") from None


def secret_of(facts: Facts) -> Secret | None:
    """Return the secret that the plan is drawn from.

    Raises:
        DamagedError: for anything else.
    """
    try:
        return None if facts.seed is None else Secret.parse(facts.seed)
    except CatchArenaError as error:
        raise DamagedError(f"table fact, row seed: {error}") from None


def versions_of(key: int, text: object) -> dict[str, str]:
    """Return the versions that played, by package.

    Raises:
        DamagedError: for anything else.
    """
    return _decode(_VERSIONS, "versions", key, "value", text)


def match_of(row: Sequence[Any], parties: int, entrants: int) -> Match:
    """Return a match of the plan.

    Args:
        row: its id, block, seed, seating and agents' seeds.
        parties: the number of parties in each match.
        entrants: the number of entrants.

    Raises:
        DamagedError: for anything else.
    """
    try:
        name, block, seed, seating, agent_seeds = msgspec.convert(tuple(row), _MATCH_ROW)
    except msgspec.ValidationError as error:
        raise DamagedError(f"table match, row {row[0]}: {error}") from None
    players = _decode(_INDICES, "match", name, "seating", seating)
    seeds = _decode(_INDICES, "match", name, "agent_seeds", agent_seeds)
    if len(players) != parties or not all(0 <= index < entrants for index in players):
        raise DamagedError(f"table match, row {name}: seating must have {parties} of {entrants} entrants")
    if seeds and len(seeds) != parties:
        raise DamagedError(f"table match, row {name}: agent_seeds must be {parties}")
    return Match(name, block, seed, players, seeds)


def played_of(row: Sequence[Any], parties: int, entrants: int) -> PlayedMatch:
    """Return a match that was played.

    Args:
        row: the values of `match_of`, its replay's digest, and RESULTS.
        parties: the number of parties in each match.
        entrants: the number of entrants.

    Raises:
        DamagedError: for anything else.
    """
    *planned, replay = row[: -len(RESULTS)]
    match = match_of(planned, parties, entrants)
    columns = zip(_DECODERS.items(), row[-len(RESULTS) :], strict=True)
    parts = {name: _decode(decoder, "result", match.id, name, text) for (name, decoder), text in columns}
    for name in _BY_PARTY:
        if len(parts[name]) != parties:
            raise DamagedError(f"table result, row {match.id}: {name} must be {parties}, got {len(parts[name])}")
    return PlayedMatch(match, MatchResult(**parts), replay)


def _decode(decoder: "msgspec.json.Decoder[T]", table: str, row: object, column: str, text: object) -> T:
    try:
        return decoder.decode(text)  # type: ignore[arg-type]  # a column may hold anything
    except (msgspec.MsgspecError, TypeError, ValueError, RecursionError) as error:
        raise DamagedError(f"table {table}, row {row}: {column}: {error}") from None
