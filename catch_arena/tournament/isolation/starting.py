"""Which agent of a match plays in which process."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import replace
from types import MappingProxyType

from catch_arena.config import ArenaConfig
from catch_arena.tournament.entrants import Entrant, is_shipped
from catch_arena.tournament.isolation.apart import Apart, players_apart
from catch_arena.tournament.isolation.isolated_players import players_together
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.players import AbsentPlayers, CompositePlayers, Fault, Players, TrustedPlayers


@contextmanager
def start_players(
    entrants: Sequence[Entrant] | Mapping[int, Entrant],
    sandbox: Sandbox | None,
    excluded_seats: Mapping[int, Fault] = MappingProxyType({}),
    apart: Apart | None = None,
) -> Iterator[Players]:
    """The players of one match, by seat, for as long as the context lasts; all that isolated agents started is ended
    with it.

    Entrants that do not come with the package are isolated in the `sandbox`, where there is one, and those that cannot
    begin are not started.

    Args:
        entrants: by seat.
        sandbox: how agents that are not trusted run.
        excluded_seats: those that are not started, and why.
        apart: how isolated agents are kept apart from each other; None where they share the sandbox.

    Raises:
        NoContest: where they could not be held, or where one of several isolated agents may have been harmed by
            another.
    """
    entrants = entrants if isinstance(entrants, Mapping) else dict(enumerate(entrants))
    faults = {seat: Fault("FORFEIT_INIT", one.fault) for seat, one in entrants.items() if one.fault is not None}
    faults |= excluded_seats
    started = {seat: one for seat, one in entrants.items() if seat not in faults}
    isolated = {seat: one for seat, one in started.items() if sandbox is not None and not is_shipped(one.spec)}
    trusted = {seat: one for seat, one in started.items() if seat not in isolated}
    with ExitStack() as stack:
        parts: list[Players] = []
        if trusted:
            parts.append(TrustedPlayers.of(trusted))
        if sandbox is not None and isolated:
            if apart is None:
                parts.append(stack.enter_context(players_together(isolated, sandbox)))
            else:
                parts.append(stack.enter_context(players_apart(isolated, sandbox.limits, apart)))
        if faults:
            parts.append(AbsentPlayers({seat: entrants[seat].control for seat in faults}, faults))
        yield parts[0] if len(parts) == 1 else CompositePlayers(parts)


def sandbox_for(limits: AgentLimits | None) -> AbstractContextManager[Sandbox | None]:
    """A sandbox with these limits; none where there are none, as all are trusted."""
    return nullcontext() if limits is None else Sandbox(limits)


def in_parties(config: ArenaConfig, entrants: Sequence[Entrant]) -> list[Entrant]:
    """Who plays in each party: its entrant, or who plays prey for it."""
    parties = Parties.of(config)
    return [entrant.on(parties.side_of(party)) for party, entrant in enumerate(entrants)]


def in_seats(config: ArenaConfig, entrants: Sequence[Entrant]) -> list[Entrant]:
    """Who plays in each seat. The further ones of a team have names of their own, as processes are kept by them."""
    found: dict[int, Entrant] = {}
    for playing, seats in zip(in_parties(config, entrants), Parties.of(config).seats, strict=True):
        for number, seat in enumerate(seats):
            found[seat] = playing if number == 0 else replace(playing, name=f"{playing.name} ({number + 1})")
    return [found[seat] for seat in range(len(found))]


def is_suspect(entrant: Entrant) -> bool:
    """Whether an entrant that is not trusted could do harm: it is started, and does not come with the package."""
    return entrant.fault is None and not is_shipped(entrant.spec)
