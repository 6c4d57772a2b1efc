"""Whole matches whose agents are isolated: begun again where we failed to hold them, and with agents apart where one of
them may have done harm.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from catch_arena.config import ArenaConfig
from catch_arena.errors import NoContest, Stalled
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation.apart import PAUSES_S, Apart, Sabotage, attempt_apart
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.isolation.starting import in_parties, in_seats, is_suspect, start_players
from catch_arena.tournament.match import MatchResult
from catch_arena.tournament.match_loop import play
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.players import Fault
from catch_arena.tournament.secret import agent_seed


def play_entrants(
    config: ArenaConfig,
    seed: int,
    entrants: Sequence[Entrant],
    sandbox: Sandbox | None,
    **options: Any,
) -> MatchResult:
    """One match of these entrants, by party; where we failed to hold it, it is played again with isolated agents apart,
    and without those who turn out to have done harm.

    Args:
        config: the arena's settings.
        seed: a whole number in [0, 2^64).
        entrants: who plays in each party (parties.py).
        sandbox: how agents that are not trusted run.
        options: those of `play`.

    Raises:
        OutputError: for a replay that cannot be written.
        NoContest: where the match could not be held.
    """
    try:
        return play_together(config, seed, entrants, sandbox, **options)
    except NoContest:
        if sandbox is None or not any(map(is_suspect, entrants)):
            raise
        sandbox.close()
    culprits: dict[int, Fault] = {}
    while True:
        try:
            return play_apart(config, seed, entrants, sandbox, excluded_parties=culprits, **options)
        except Sabotage as found:
            culprits[Parties.of(config).by_seat[found.seat]] = Fault("FORFEIT_SABOTAGE", found.what)


def play_together(
    config: ArenaConfig,
    seed: int,
    entrants: Sequence[Entrant],
    sandbox: Sandbox | None,
    *,
    excluded_parties: Mapping[int, Fault] = MappingProxyType({}),
    agent_seeds: Sequence[int] = (),
    **options: Any,
) -> MatchResult:
    """One match, all isolated agents at once. One in which we stood still is played again, three times at most.

    Args:
        config: the arena's settings.
        seed: a whole number in [0, 2^64).
        entrants: who plays in each party.
        sandbox: how agents that are not trusted run.
        excluded_parties: those that are not started, and why.
        agent_seeds: what each party is told as its seed; where there are none they follow from `seed`.
        options: the others of `play`.

    Raises:
        OutputError: for a replay that cannot be written.
        NoContest: where the match could not be held.
    """
    pauses = iter(PAUSES_S[1:])
    while True:
        try:
            return _play_once(config, seed, entrants, sandbox, excluded_parties, agent_seeds, None, options)
        except Stalled:
            pause = next(pauses, None)
            if pause is None:
                raise
            time.sleep(pause)


def play_apart(
    config: ArenaConfig,
    seed: int,
    entrants: Sequence[Entrant],
    sandbox: Sandbox,
    *,
    excluded_parties: Mapping[int, Fault] = MappingProxyType({}),
    agent_seeds: Sequence[int] = (),
    on_turn: Callable[[int], None] | None = None,
    disks: Mapping[str, Path] = MappingProxyType({}),
    **options: Any,
) -> MatchResult:
    """One match, isolated agents one at a time, so that whoever does harm is found.

    Args:
        config: the arena's settings.
        seed: a whole number in [0, 2^64).
        entrants: who plays in each party.
        sandbox: whose limits they have.
        excluded_parties: those that are not started, and why.
        agent_seeds: what each party is told as its seed; where there are none they follow from `seed`.
        on_turn: called with a seat before it runs.
        disks: folders whose disks nobody may fill, by what is said of them; that of the agents' folders besides.
        options: the others of `play`.

    Raises:
        Sabotage: where a seat did harm; nothing of it runs on.
        OutputError: for a replay that cannot be written.
        NoContest: where the match could not be held, and no agent is to blame.
    """

    def attempt(apart: Apart) -> MatchResult:
        return _play_once(config, seed, entrants, sandbox, excluded_parties, agent_seeds, apart, options)

    return attempt_apart(attempt, on_turn, disks)


def _play_once(
    config: ArenaConfig,
    seed: int,
    entrants: Sequence[Entrant],
    sandbox: Sandbox | None,
    excluded_parties: Mapping[int, Fault],
    agent_seeds: Sequence[int],
    apart: Apart | None,
    options: Mapping[str, Any],
) -> MatchResult:
    """A match from its parties, in its seats; arguments as of `play_together`, `apart` as of `start_players`."""
    parties = Parties.of(config)
    names = parties.to_seats([entrant.name for entrant in in_parties(config, entrants)])
    seeds = _seeds_by_seat(parties, agent_seeds) if agent_seeds else ()
    seated, absent = in_seats(config, entrants), parties.mapped_to_seats(excluded_parties)
    with start_players(seated, sandbox, absent, apart) as players:
        return play(config, seed, players, names, agent_seeds=seeds, **options)


def _seeds_by_seat(parties: Parties, agent_seeds: Sequence[int]) -> list[int]:
    """What each seat is told as its seed: the first of a team what its party is, the others what follows from that."""
    found: dict[int, int] = {}
    for seed, seats in zip(agent_seeds, parties.seats, strict=True):
        for number, seat in enumerate(seats):
            found[seat] = agent_seed(seed, number) if number else seed
    return [found[seat] for seat in range(len(found))]
