"""One match in the window, as often as its user wants it."""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, NamedTuple

from catch_arena.config import ArenaConfig, Control
from catch_arena.live.match_window import MatchWindow, QuitRequested, RestartRequested
from catch_arena.live.user_input import InputState
from catch_arena.policy import Policy, View
from catch_arena.render.viewport import MatchInfo
from catch_arena.replay import Replay
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import play


class HumanPolicy:
    """Drives by hand; the nearest target within reach is requested for it (R4.4)."""

    control: ClassVar[Control] = "velocity"

    def __init__(self, inputs: InputState) -> None:
        self._inputs = inputs

    def reset(self, seed: int) -> None:
        """Nothing is held from the match before."""
        del seed
        self._inputs.release_all()

    def act(self, view: View) -> tuple[float, float]:
        """What the person commands."""
        del view
        return self._inputs.velocity_command()


@dataclass(frozen=True, slots=True)
class Lineup:
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

    def policies(self, inputs: InputState) -> list[Policy]:
        """Fresh ones, for one match."""
        return [HumanPolicy(inputs) if player is None else player.create() for player in self.players]


class SessionResult(NamedTuple):
    """What was played last, to its end or not; scores and ranks by seat."""

    replay: Replay
    scores: tuple[int, ...]
    ranks: tuple[int, ...]


def show_match(
    config: ArenaConfig,
    seed: int,
    lineup: Lineup,
    *,
    title: str,
    size: tuple[int, int],
    save: Callable[[Replay], str],
) -> SessionResult:
    """Play a match in a window until its user has seen enough.

    The arguments are those of `tournament.match.play`, with the `size` of the window, and `save`, which is called when
    the user asks for it and says where the replay is.

    Raises:
        OutputError: without a display.
        AgentError: where an agent cannot be used.
    """
    inputs = InputState()
    window = MatchWindow(
        MatchInfo.of(config, lineup.names, title),
        seed,
        size,
        inputs=None if lineup.person is None else inputs,
        seat=lineup.person,
        save=save,
    )
    try:
        with tempfile.TemporaryDirectory() as folder:
            record = Path(folder, "match.replay")  # a match is recorded where it is to be written; `save` decides
            while True:
                try:
                    play(config, seed, lineup.policies(inputs), lineup.names, title=title, record=record, watch=window)
                except RestartRequested:
                    continue
                except QuitRequested:
                    pass
                return SessionResult(window.replay, window.scores, window.ranks)
    finally:
        window.close()


def line_up(players: Sequence[Entrant], hunters: int, person: int | None) -> Lineup:
    """The entrants in their order, about the person's seat."""
    rest = iter(players)
    return Lineup(tuple(None if seat == person else next(rest) for seat in range(hunters)))
