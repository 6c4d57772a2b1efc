"""One match in the window, as often as its user wants it."""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from catch_arena.config import ArenaConfig
from catch_arena.live.keys import Hands
from catch_arena.live.person import Person
from catch_arena.live.show import Again, Ended, Show
from catch_arena.policy import Policy
from catch_arena.render.viewport import MatchInfo
from catch_arena.replay import Replay
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import play


@dataclass(frozen=True, slots=True)
class Seats:
    """Who plays: entrants by seat, None for the person."""

    players: tuple[Entrant | None, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The person is «you»."""
        return tuple("you" if player is None else player.name for player in self.players)

    @property
    def person(self) -> int | None:
        """The person's seat."""
        return self.players.index(None) if None in self.players else None

    def policies(self, hands: Hands) -> list[Policy]:
        """Fresh ones, for one match."""
        return [Person(hands) if player is None else player.create() for player in self.players]


class Outcome(NamedTuple):
    """What was played last, to its end or not; scores and ranks by seat."""

    replay: Replay
    scores: tuple[int, ...]
    ranks: tuple[int, ...]


def show_match(
    config: ArenaConfig,
    seed: int,
    seats: Seats,
    *,
    title: str,
    size: tuple[int, int],
    save: Callable[[Replay], str],
) -> Outcome:
    """Play a match in a window until its user has seen enough.

    Args: as for `tournament.match.play`; `size` of the window; `save`, called when the user asks for it, says where
    the replay is.
    Raises: OutputError without a display; AgentError.
    """
    hands = Hands()
    show = Show(
        MatchInfo.of(config, seats.names, title),
        seed,
        size,
        hands=None if seats.person is None else hands,
        seat=seats.person,
        save=save,
    )
    try:
        with tempfile.TemporaryDirectory() as folder:
            record = Path(folder, "match.replay")  # a match is recorded where it is to be written; `save` decides
            while True:
                try:
                    play(config, seed, seats.policies(hands), seats.names, title=title, record=record, watch=show)
                except Again:
                    continue
                except Ended:
                    pass
                return Outcome(show.replay, show.scores, show.ranks)
    finally:
        show.close()


def seated(players: Sequence[Entrant], hunters: int, person: int | None) -> Seats:
    """The entrants in their order, about the person's seat."""
    rest = iter(players)
    return Seats(tuple(None if seat == person else next(rest) for seat in range(hunters)))
