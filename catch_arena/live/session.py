"""Session of one match in the window, which its user may restart any number of times."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from io import BytesIO
from typing import NamedTuple

from catch_arena.config import ArenaConfig
from catch_arena.live.match_window import MatchWindow, RestartRequested
from catch_arena.live.user_input import HumanPolicy
from catch_arena.policy import Policy
from catch_arena.render.match_info import MatchInfo
from catch_arena.replay import Replay
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import sandbox_for
from catch_arena.tournament.match import MatchResult
from catch_arena.tournament.match_loop import in_seats, play_match
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.players import Players


class ShownMatch(NamedTuple):
    """Match that was played last, ended or not."""

    result: MatchResult
    replay: Replay
    names: tuple[str, ...]
    """Names of the teams and the prey, by party (tournament/parties.py)."""


def show_match(
    config: ArenaConfig,
    seed: int,
    entrants: Mapping[int, Entrant],
    seat: int | None,
    quotas: Quotas | None,
    *,
    title: str,
    size: tuple[int, int],
    save: Callable[[Replay], str],
) -> ShownMatch:
    """Play a match in a window until its user has seen enough.

    The entrants are by party; a party that is the person's alone has none. `seat` is None without a person, and
    `quotas` if all agents are trusted. `save` is called with the replay when the user asks for it, and returns a text
    that says where it is. Raises OutputError without a display.
    """
    parties, person = Parties.of(config), HumanPolicy()
    stand_in = next(iter(entrants.values()))  # for a party that is the person alone
    agents = [entrants.get(party, stand_in) for party in range(len(parties))]
    playing = in_seats(config, agents)
    seated: list[Entrant | Policy] = [*playing]
    names = [one.name for one in playing]
    if seat is not None:
        seated[seat], names[seat] = person, "you"
    info = MatchInfo.of(config, names, title)
    window = MatchWindow(info, seed, size, person, seat, save)
    try:
        with sandbox_for(quotas) as sandbox:
            while True:
                with (
                    suppress(RestartRequested),
                    Players(seated, sandbox, while_waiting=window.wait) as players,
                ):
                    result = play_match(
                        config,
                        seed,
                        players,
                        names,
                        title=title,
                        record=BytesIO(),  # a recorded match can be saved at any time
                        watch=window,
                        on_forfeit=lambda seat, forfeit: window.notify(f"{names[seat]} has forfeited: {forfeit}"),
                    )
                    window.show_podium()
                    called = tuple(info.called(seats[0]) for seats in parties.seats)
                    return ShownMatch(result, window.replay, called)
    finally:
        window.close()
