"""Rows of a store as objects: msgspec decodes each and checks its types."""

import json
from collections.abc import Mapping, Sequence
from typing import Any, Final, TypeVar

import msgspec

from catch_arena.tournament.match import Match, MatchResult, PlayedMatch

_COLUMNS: Final = (
    *("scores", "ranks", "verdicts", "contests_won", "contests_lost", "steps", "digest"),
    *("forfeits", "thinking", "details", "lost_to_mates", "catches"),
)
RESULTS: Final = {name: name for name in _COLUMNS} | {"forfeits": "forfeit_codes", "details": "forfeits"}
"""Columns of a result in their order, each with JSON, and the attributes of `MatchResult` that they hold."""
_BY_PARTY: Final = ("scores", "ranks", "verdicts", "contests_won", "contests_lost", "forfeits", "thinking")

T = TypeVar("T")


class DamagedError(Exception):
    """Error for a stored value that no command has written; the text names the table, the row and the value."""


_VERSIONS: Final = msgspec.json.Decoder(dict[str, str])
_MATCH: Final = msgspec.json.Decoder(Match)
_RESULT: Final = msgspec.json.Decoder(MatchResult)


def decode_versions(key: int, text: str) -> dict[str, str]:
    """Return the versions that played, by package; like the functions below, raise DamagedError for wrong values."""
    return _decode(_VERSIONS, f"table versions, row {key}", text)


def decode_match(row: Sequence[Any], parties: int, entrants: int) -> Match:
    """Return a match of the plan.

    Args:
        row: its id, block, seed, seating and agents' seeds.
        parties: number of parties in each match.
        entrants: number of entrants.
    """
    name, block, seed, seating, agent_seeds = row
    where = f"table match, row {name}"
    values = {"id": json.dumps(name), "block": block, "seed": seed, "seating": seating, "agent_seeds": agent_seeds}
    match = _decode(_MATCH, where, _object(values))
    if len(match.seating) != parties or not all(0 <= index < entrants for index in match.seating):
        raise DamagedError(f"{where}: seating must have {parties} of {entrants} entrants")
    if len(match.agent_seeds) != parties:
        raise DamagedError(f"{where}: agent_seeds must be {parties}")
    return match


def decode_played_match(row: Sequence[Any], parties: int, entrants: int) -> PlayedMatch:
    """Return a played match; its row has the values of `decode_match`, the replay's digest, and RESULTS."""
    *planned, replay = row[: -len(RESULTS)]
    match = decode_match(planned, parties, entrants)
    where = f"table result, row {match.id}"
    result = _decode(_RESULT, where, _object(dict(zip(RESULTS.values(), row[-len(RESULTS) :], strict=True))))
    if wrong := [name for name in _BY_PARTY if len(getattr(result, name)) != parties]:
        raise DamagedError(f"{where}: {wrong[0]} must be {parties}")
    return PlayedMatch(match, result, replay)


def _object(values: Mapping[str, object]) -> str:
    """Return the JSON of an object whose values are JSON texts or integers."""
    return "{" + ",".join(f'"{name}":{value}' for name, value in values.items()) + "}"


def _decode(decoder: "msgspec.json.Decoder[T]", where: str, text: str) -> T:
    try:
        return decoder.decode(text)
    except (msgspec.MsgspecError, RecursionError, TypeError, UnicodeError) as error:
        raise DamagedError(f"{where}: {error}") from None
