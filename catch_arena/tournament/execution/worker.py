"""What plays the matches of a block, in whatever process."""

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from io import BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.errors import NoContest
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation.apart import Sabotage
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.playing import play_apart, play_together
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.isolation.starting import is_suspect
from catch_arena.tournament.match import Block, Match, MatchResult, PlayedMatch, players_of
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.players import Fault

_DIGEST_BYTES: Final = 16

Excluded = Mapping[int, Fault]
"""Entrants that are not started, by index, and why."""
RecordedMatch = tuple[PlayedMatch, bytes]
"""A match that was played, and the content of its replay's file: empty where none was asked for."""


class EntrantSabotage(NoContest):
    """An entrant has harmed others, or what holds the match: `Sabotage`, where seats change from match to match.

    Args:
        entrant: its index.
        what: it did.
    """

    def __init__(self, entrant: int, what: str) -> None:
        super().__init__(entrant, what)
        self.entrant, self.what = entrant, what


@dataclass(frozen=True, slots=True)
class Worker:
    """Plays matches; it can be sent to another process, and makes fresh instances of the agents there."""

    config: ArenaConfig
    entrants: tuple[Entrant, ...]
    record: bool = False
    """Whether replays are made."""
    limits: AgentLimits | None = None
    """Those of isolated agents; None where all are trusted."""

    @property
    def sandbox(self) -> Sandbox | None:
        """Where its agents are isolated: one for each process, which waits there for the next match."""
        return None if self.limits is None else _sandbox(self.limits)

    def suspects(self, block: Block, excluded: Iterable[int]) -> list[int]:
        """Whose processes run in a block, and could do harm: the indices of isolated entrants that are started."""
        if self.limits is None:
            return []
        return [index for index in players_of(block) if index not in excluded and is_suspect(self.entrants[index])]

    def play(self, matches: Iterable[Match], excluded: Excluded = MappingProxyType({})) -> list[RecordedMatch]:
        """One match after the other.

        Args:
            matches: which matches.
            excluded: the indices of entrants that are not started, and why.

        Raises:
            NoContest: for a match that could not be held.
        """
        return [self._recorded(match, excluded, play_together) for match in matches]

    def play_apart(
        self, matches: Iterable[Match], excluded: Excluded, on_turn: Callable[[int], None], disks: Mapping[str, Path]
    ) -> list[RecordedMatch]:
        """One match after the other, isolated agents one at a time (isolation.apart).

        Args:
            matches: which matches.
            excluded: the indices of entrants that are not started, and why.
            on_turn: called with the index of an entrant before it runs.
            disks: as of `play_apart`.

        Raises:
            EntrantSabotage: for one that did harm.
            NoContest: for a match that could not be held, time and again.
        """
        played = []
        parties = Parties.of(self.config)
        for match in matches:
            seating = parties.to_seats(match.seating)
            by_seat = partial(_tell_index, on_turn, seating)
            try:
                played.append(self._recorded(match, excluded, partial(play_apart, on_turn=by_seat, disks=disks)))
            except Sabotage as found:
                raise EntrantSabotage(seating[found.seat], found.what) from None
        return played

    def close(self) -> None:
        """End the agents that wait in this process for their next match; they end with it at the latest."""
        if self.sandbox is not None:
            self.sandbox.close()

    def _recorded(self, match: Match, excluded: Excluded, play: Callable[..., MatchResult]) -> RecordedMatch:
        replay = BytesIO() if self.record else None
        result = play(
            self.config,
            match.seed,
            [self.entrants[index] for index in match.seating],
            self.sandbox,
            excluded_parties={party: excluded[index] for party, index in enumerate(match.seating) if index in excluded},
            agent_seeds=match.agent_seeds,
            title=f"match {match.id}",
            record=replay,
        )
        if replay is None:
            return PlayedMatch(match, result), b""
        content = replay.getvalue()
        return PlayedMatch(match, result, hashlib.blake2b(content, digest_size=_DIGEST_BYTES).hexdigest()), content


def _tell_index(on_turn: Callable[[int], None], seating: Sequence[int], seat: int) -> None:
    on_turn(seating[seat])


@cache
def _sandbox(limits: AgentLimits) -> Sandbox:
    return Sandbox(limits)
