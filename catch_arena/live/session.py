"""Session of one match in the window, which its user may restart any number of times."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from io import BytesIO
from typing import NamedTuple

from catch_arena.config import ArenaConfig
from catch_arena.live.match_window import MatchWindow, RestartRequested
from catch_arena.live.user_input import HumanPolicy
from catch_arena.render.match_info import MatchInfo
from catch_arena.replay import Replay
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation.playing import in_seats, sandbox_for, start_players
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.match import MatchResult
from catch_arena.tournament.match_loop import play_match
from catch_arena.tournament.parties import Parties


@dataclass(frozen=True, slots=True)
class Lineup:
    """Players by seat: first the hunters' seats, then those of the prey."""

    entrants: tuple[Entrant | None, ...]
    """Entrants by seat, None for the person."""
    names: tuple[str, ...]
    """Names by seat; the person is «you»."""

    @property
    def person(self) -> int | None:
        """Seat of the person, None without one."""
        return self.entrants.index(None) if None in self.entrants else None


class ShownMatch(NamedTuple):
    """Match that was played last, ended or not."""

    result: MatchResult
    replay: Replay
    names: tuple[str, ...]
    """Names of the teams and the prey, by party (tournament/parties.py)."""


def show_match(
    config: ArenaConfig,
    seed: int,
    lineup: Lineup,
    quotas: Quotas | None,
    *,
    title: str,
    size: tuple[int, int],
    save: Callable[[Replay], str],
) -> ShownMatch:
    """Play a match in a window until its user has seen enough.

    Args:
        config: the arena's settings.
        seed: a whole number in [0, 2^64).
        lineup: the players by seat.
        quotas: quotas of isolated agents, None if all agents are trusted.
        title: title of the replay and of the window.
        size: (width, height) of the window [pixels].
        save: called with the replay when the user asks for it; returns a text that says where the replay is.

    Raises:
        OutputError: if there is no display.
        MatchFailedError: if isolated agents could not be held.
    """
    person = HumanPolicy()
    seated = {seat: entrant or person for seat, entrant in enumerate(lineup.entrants)}
    info = MatchInfo.of(config, lineup.names, title)
    window = MatchWindow(info, seed, size, person, lineup.person, save)
    try:
        with sandbox_for(quotas) as sandbox:
            while True:
                with (
                    suppress(RestartRequested),
                    start_players(seated, sandbox, while_waiting=window.wait) as players,
                ):
                    result = play_match(
                        config,
                        seed,
                        players,
                        lineup.names,
                        title=title,
                        record=BytesIO(),  # a recorded match can be saved at any time
                        watch=window,
                        on_forfeit=lambda seat, forfeit: window.notify(
                            f"{lineup.names[seat]} has forfeited: {forfeit}"
                        ),
                    )
                    window.show_result(result)
                    names = tuple(info.called(seats[0]) for seats in Parties.of(config).seats)
                    return ShownMatch(result, window.replay, names)
    finally:
        window.close()


def free_parties(config: ArenaConfig, person: int | None) -> list[int]:
    """Return the parties in which agents play: all but a party whose only seat is the person's."""
    return [party for party, seats in enumerate(Parties.of(config).seats) if seats != (person,)]


def line_up(config: ArenaConfig, entrants: Sequence[Entrant], person: int | None) -> Lineup:
    """Return the lineup with the entrants in the free parties, in their order, and the person in its seat."""
    parties = Parties.of(config)
    entered = dict(zip(free_parties(config, person), entrants, strict=True))
    seated: list[Entrant | None] = []
    names = []
    for seat, entrant in enumerate(
        in_seats(config, [entered.get(party, entrants[0]) for party in range(len(parties))])
    ):
        party = parties.by_seat[seat]
        seated.append(None if seat == person else entrant)
        names.append("you" if seat == person else entered[party].on(parties.side_of(party)).name)
    return Lineup(tuple(seated), tuple(names))
