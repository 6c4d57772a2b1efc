"""Matches of entrants: trusted agents play in this process, and all others in their own processes."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from catch_arena.config import ArenaConfig
from catch_arena.policy import Policy
from catch_arena.tournament.agent_spec import is_shipped
from catch_arena.tournament.entrants import Entrant, Inspection, inspect_agent
from catch_arena.tournament.isolation.isolated_players import isolated_players
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match import MatchResult
from catch_arena.tournament.match_loop import play_match
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.players import Fault, Players
from catch_arena.tournament.secret import agent_seed


def play_entrants(
    config: ArenaConfig,
    seed: int,
    entrants: Sequence[Entrant],
    sandbox: Sandbox | None,
    *,
    absent: Mapping[int, Fault] = MappingProxyType({}),
    agent_seeds: Sequence[int] = (),
    **options: Any,
) -> MatchResult:
    """Play one match of these entrants, and return its result.

    Args:
        config: the arena's settings.
        seed: an integer in [0, 2^64).
        entrants: the entrants by party (parties.py).
        sandbox: runs agents that are not trusted; None if all are trusted.
        absent: reasons for which parties are not started, by party.
        agent_seeds: seed of each party; if empty, these seeds follow from `seed`.
        options: further arguments of `match_loop.play_match`.

    Raises:
        OutputError: for a replay that cannot be written.
        MatchFailedError: for a match that failed on our side.
    """
    parties = Parties.of(config)
    playing = in_parties(config, entrants)
    names = [playing[party].name for party in parties.by_seat]
    absent = {seat: absent[party] for seat, party in enumerate(parties.by_seat) if party in absent}
    seeds = [_instance_seed(agent_seeds[party], number) for party, number in parties.places] if agent_seeds else []
    with start_players(in_seats(config, entrants), sandbox, absent) as players:
        return play_match(config, seed, players, names, agent_seeds=seeds, **options)


def start_players(
    seated: Sequence[Entrant] | Mapping[int, Entrant] | Mapping[int, Entrant | Policy],
    sandbox: Sandbox | None,
    absent: Mapping[int, Fault] = MappingProxyType({}),
    while_waiting: Callable[[], None] | None = None,
) -> AbstractContextManager[Players]:
    """Return a context manager with the players of one match, by seat; its exit ends their processes.

    Agents that come with the package, and all agents if there is no sandbox, play in this process.

    Args:
        seated: entrants, or instances that play in this process, by seat.
        sandbox: runs agents that are not trusted; None if all are trusted.
        absent: the fault of each seat for which no player is started, by seat.
        while_waiting: called repeatedly while isolated agents think, as in `IsolatedPlayers`.

    Raises:
        MatchFailedError: for a match that failed on our side.
    """
    seated = seated if isinstance(seated, Mapping) else dict(enumerate(seated))
    entrants = {seat: one for seat, one in seated.items() if isinstance(one, Entrant)}
    cannot_play = {
        seat: Fault("FORFEIT_INIT", one.fault, log=one.log) for seat, one in entrants.items() if one.fault is not None
    }
    absent = cannot_play | dict(absent)
    isolated = {seat: one for seat, one in entrants.items() if seat not in absent and not is_shipped(one.spec)}
    if sandbox is None or not isolated:
        return nullcontext(Players(seated, absent))
    here = {seat: one for seat, one in seated.items() if seat not in isolated}
    return isolated_players(sandbox, isolated, here, absent, while_waiting)


def sandbox_for(quotas: Quotas | None) -> AbstractContextManager[Sandbox | None]:
    """Return a context manager with a sandbox of these quotas, or with None if all agents are trusted."""
    return nullcontext() if quotas is None else Sandbox(quotas)


def inspector(sandbox: Sandbox | None) -> Callable[[str], Inspection]:
    """Return a function that inspects an agent for `enter`, in the kind of process in which the agent would play."""

    def inspect(spec: str) -> Inspection:
        if sandbox is None or is_shipped(spec):
            return inspect_agent(spec)
        with isolated_players(sandbox, {0: Entrant(spec, spec, "target", "")}) as players:
            return players.inspect()

    return inspect


def in_parties(config: ArenaConfig, entrants: Sequence[Entrant]) -> list[Entrant]:
    """Return the player of each party: its entrant, or the entrant that plays prey for it."""
    parties = Parties.of(config)
    return [entrant.on(parties.side_of(party)) for party, entrant in enumerate(entrants)]


def in_seats(config: ArenaConfig, entrants: Sequence[Entrant]) -> list[Entrant]:
    """Return the player of each seat. Further seats of a team have different names: processes are kept by names."""
    playing = in_parties(config, entrants)
    return [
        replace(playing[party], name=f"{playing[party].name} ({number + 1})", log="") if number else playing[party]
        for party, number in Parties.of(config).places
    ]


def _instance_seed(seed: int, number: int) -> int:
    """Return the seed of a party's instance: the party's seed for the first, and seeds derived from it for others."""
    return agent_seed(seed, number) if number else seed
