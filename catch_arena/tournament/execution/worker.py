"""Worker, which plays the matches of a block in any process."""

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match import Fault, Match, PlayedMatch
from catch_arena.tournament.match_loop import play_entrants
from catch_arena.tournament.parties import Parties

_DIGEST_BYTES: Final = 16

RecordedMatch = tuple[PlayedMatch, bytes]
"""Played match, and the content of its replay's file; empty if no replay is made."""


@dataclass(frozen=True, slots=True)
class Worker:
    """Player of matches that can be sent to another process, in which it makes new instances of the agents."""

    config: ArenaConfig
    entrants: tuple[Entrant, ...]
    record: bool = False
    """True to make replays."""
    quotas: Quotas | None = None
    """Quotas of isolated agents; None if all are trusted."""

    @property
    def sandbox(self) -> Sandbox | None:
        """Sandbox of its agents, one per process; agents wait in it for the next match. None if all are trusted."""
        return None if self.quotas is None else _sandbox(self.quotas)

    def play_block(self, matches: Iterable[Match], excluded: Mapping[int, Fault]) -> list[RecordedMatch]:
        """Play one match after the other.

        Args:
            matches: the matches to play.
            excluded: reasons for which entrants are not started, by index.

        Raises:
            MatchFailedError: for a match that failed on our side.
        """
        return [self._recorded(match, excluded) for match in matches]

    def close(self) -> None:
        """End the agents that wait in this process for their next match."""
        if self.sandbox is not None:
            self.sandbox.close()

    def _recorded(self, match: Match, excluded: Mapping[int, Fault]) -> RecordedMatch:
        replay, parties = BytesIO() if self.record else None, Parties.of(self.config)
        result = play_entrants(
            self.config,
            match.seed,
            [self.entrants[index] for index in match.seating],
            self.sandbox,
            absent={party: excluded[index] for party, index in enumerate(match.seating) if index in excluded},
            agent_seeds=match.agent_seeds,
            title=match.title(parties.block_size),
            record=replay,
            colors=[match.seating[party] for party in parties.by_seat[: self.config.hunters]],
        )
        if replay is None:
            return PlayedMatch(match, result), b""
        content = replay.getvalue()
        return PlayedMatch(match, result, hashlib.blake2b(content, digest_size=_DIGEST_BYTES).hexdigest()), content


@cache
def _sandbox(quotas: Quotas) -> Sandbox:
    return Sandbox(quotas)
