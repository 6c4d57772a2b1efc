"""What plays the matches of a block, in whatever process."""

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from types import MappingProxyType
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.isolation.starting import play_entrants
from catch_arena.tournament.match import Match, MatchResult, PlayedMatch

_DIGEST_BYTES: Final = 16

RecordedMatch = tuple[PlayedMatch, bytes]
"""A match that was played, and the content of its replay's file: empty where none was asked for."""


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

    def play(self, matches: Iterable[Match], excluded: Mapping[int, str] = MappingProxyType({})) -> list[RecordedMatch]:
        """One match after the other.

        Args:
            matches: which matches.
            excluded: the indices of entrants that are not started, and why.

        Raises:
            NoContest: for a match that could not be held, time and again.
        """
        return [
            self._recorded(match, excluded) if self.record else (PlayedMatch(match, self._result(match, excluded)), b"")
            for match in matches
        ]

    def close(self) -> None:
        """End the agents that wait in this process for their next match; they end with it at the latest."""
        if self.sandbox is not None:
            self.sandbox.close()

    def _recorded(self, match: Match, excluded: Mapping[int, str]) -> RecordedMatch:
        replay = BytesIO()
        result = self._result(match, excluded, replay)
        content = replay.getvalue()
        return PlayedMatch(match, result, hashlib.blake2b(content, digest_size=_DIGEST_BYTES).hexdigest()), content

    def _result(self, match: Match, excluded: Mapping[int, str], record: BytesIO | None = None) -> MatchResult:
        players = [self.entrants[index] for index in match.seating]
        return play_entrants(
            self.config,
            match.seed,
            players,
            self.sandbox,
            excluded={seat: excluded[index] for seat, index in enumerate(match.seating) if index in excluded},
            agent_seeds=match.agent_seeds,
            title=f"match {match.id}",
            record=record,
        )


@cache
def _sandbox(limits: AgentLimits) -> Sandbox:
    return Sandbox(limits)
