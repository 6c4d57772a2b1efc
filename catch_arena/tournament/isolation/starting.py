"""Which agent of a match plays in which process: what the rest of the package uses of this folder."""

import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, NamedTuple, TypeVar

from catch_arena.config import ArenaConfig
from catch_arena.errors import NoContest, Stalled
from catch_arena.tournament.entrants import Entrant, Inspection, inspect_agent, is_shipped
from catch_arena.tournament.isolation.apart import ApartPlayers, Sabotage
from catch_arena.tournament.isolation.isolated_players import IsolatedPlayers
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.newcomers import no_newcomers_left
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match import MatchResult, agent_seed, play
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.players import AbsentPlayers, CompositePlayers, Fault, Players, TrustedPlayers

_PAUSES_S: Final = (0.0, 1.0, 5.0)
"""How long we wait before a match is begun again that we failed to hold, and how often it is begun."""


_Result = TypeVar("_Result")


class Apart(NamedTuple):
    """How isolated agents are kept apart from each other: the arguments of ApartPlayers."""

    on_turn: Callable[[int], None]
    disks: Mapping[str, Path]


@contextmanager
def start_players(
    entrants: Sequence[Entrant] | Mapping[int, Entrant],
    sandbox: Sandbox | None,
    excluded: Mapping[int, Fault] = MappingProxyType({}),
    apart: Apart | None = None,
) -> Iterator[Players]:
    """The players of one match, by seat, for as long as the context lasts; all that isolated agents started is ended
    with it.

    Entrants that do not come with the package are isolated in the `sandbox`, where there is one, and those that cannot
    begin are not started.

    Args:
        entrants: by seat.
        sandbox: how agents that are not trusted run.
        excluded: seats that are not started, and why.
        apart: how isolated agents are kept apart from each other; None where they share the sandbox.

    Raises:
        NoContest: where they could not be held, or where one of several isolated agents may have been harmed by
            another.
    """
    entrants = entrants if isinstance(entrants, Mapping) else dict(enumerate(entrants))
    faults = {seat: Fault("FORFEIT_INIT", one.fault) for seat, one in entrants.items() if one.fault is not None}
    faults |= excluded
    started = {seat: one for seat, one in entrants.items() if seat not in faults}
    isolated = {seat: one for seat, one in started.items() if sandbox is not None and not is_shipped(one.spec)}
    trusted = {seat: one for seat, one in started.items() if seat not in isolated}
    with ExitStack() as stack:
        parts: list[Players] = []
        if trusted:
            parts.append(TrustedPlayers.of(trusted))
        if sandbox is not None and isolated:
            if apart is None:
                parts.append(stack.enter_context(_isolated(isolated, sandbox)))
            else:
                parts.append(stack.enter_context(_apart(isolated, sandbox.limits, apart)))
        if faults:
            parts.append(AbsentPlayers({seat: entrants[seat].control for seat in faults}, faults))
        yield parts[0] if len(parts) == 1 else CompositePlayers(parts)


def sandbox_for(limits: AgentLimits | None) -> AbstractContextManager[Sandbox | None]:
    """A sandbox with these limits; none where there are none, as all are trusted."""
    return nullcontext() if limits is None else Sandbox(limits)


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
            return play_apart(config, seed, entrants, sandbox, excluded=culprits, **options)
        except Sabotage as found:
            culprits[Parties.of(config).by_seat[found.who]] = Fault("FORFEIT_SABOTAGE", found.what)


def in_seats(config: ArenaConfig, entrants: Sequence[Entrant]) -> list[Entrant]:
    """Who plays in each seat: the entrant of its party, or who plays prey for it. The further ones of a team have names
    of their own, as processes are kept by them.
    """
    parties = Parties.of(config)
    found: dict[int, Entrant] = {}
    for party, (entrant, seats) in enumerate(zip(entrants, parties.seats, strict=True)):
        playing = entrant.as_prey() if parties.side_of(party) == "prey" else entrant
        for number, seat in enumerate(seats):
            found[seat] = playing if number == 0 else replace(playing, name=f"{playing.name} ({number + 1})")
    return [found[seat] for seat in range(len(found))]


def _seeds_by_seat(parties: Parties, agent_seeds: Sequence[int]) -> list[int]:
    """What each seat is told as its seed: the first of a team what its party is, the others what follows from that."""
    found: dict[int, int] = {}
    for seed, seats in zip(agent_seeds, parties.seats, strict=True):
        for number, seat in enumerate(seats):
            found[seat] = agent_seed(seed, number) if number else seed
    return [found[seat] for seat in range(len(found))]


def play_together(
    config: ArenaConfig,
    seed: int,
    entrants: Sequence[Entrant],
    sandbox: Sandbox | None,
    *,
    excluded: Mapping[int, Fault] = MappingProxyType({}),
    agent_seeds: Sequence[int] = (),
    **options: Any,
) -> MatchResult:
    """One match, all isolated agents at once. One in which we stood still is played again, three times at most.

    Args:
        config: the arena's settings.
        seed: a whole number in [0, 2^64).
        entrants: who plays in each party.
        sandbox: how agents that are not trusted run.
        excluded: parties that are not started, and why.
        agent_seeds: what each party is told as its seed; where there are none they follow from `seed`.
        options: the others of `play`.

    Raises:
        OutputError: for a replay that cannot be written.
        NoContest: where the match could not be held.
    """
    parties = Parties.of(config)
    names = parties.to_seats([entrant.name for entrant in entrants])
    seeds = _seeds_by_seat(parties, agent_seeds) if agent_seeds else ()
    seated, absent = in_seats(config, entrants), parties.mapped_to_seats(excluded)
    pauses = iter(_PAUSES_S[1:])
    while True:
        try:
            with start_players(seated, sandbox, absent) as players:
                return play(config, seed, players, names, agent_seeds=seeds, **options)
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
    excluded: Mapping[int, Fault] = MappingProxyType({}),
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
        excluded: parties that are not started, and why.
        agent_seeds: what each party is told as its seed; where there are none they follow from `seed`.
        on_turn: called with a seat before it runs.
        disks: folders whose disks nobody may fill, by what is said of them; that of the agents' folders besides.
        options: the others of `play`.

    Raises:
        Sabotage: where a seat did harm; nothing of it runs on.
        OutputError: for a replay that cannot be written.
        NoContest: where the match could not be held, and no agent is to blame.
    """
    parties = Parties.of(config)
    names = parties.to_seats([entrant.name for entrant in entrants])
    seeds = _seeds_by_seat(parties, agent_seeds) if agent_seeds else ()
    seated, absent = in_seats(config, entrants), parties.mapped_to_seats(excluded)

    def attempt(apart: Apart) -> MatchResult:
        with start_players(seated, sandbox, absent, apart) as players:
            return play(config, seed, players, names, agent_seeds=seeds, **options)

    return _attempt_apart(attempt, on_turn, disks)


def is_suspect(entrant: Entrant) -> bool:
    """Whether an entrant that is not trusted could do harm: it is started, and does not come with the package."""
    return entrant.fault is None and not is_shipped(entrant.spec)


def inspector(sandbox: Sandbox | None) -> Callable[[str], Inspection]:
    """How `enter` looks at agents: in this process where it would play them here, else in processes of their own.

    One that harms what keeps it, whenever it is looked at, cannot play.
    """
    if sandbox is None:
        return inspect_agent

    def look(seats: Mapping[int, Entrant]) -> Inspection:
        with _isolated(seats, sandbox) as players:
            found = players.inspect()
            sandbox.end(seats[0])
        return found

    def inspect(spec: str) -> Inspection:
        if is_shipped(spec):
            return inspect_agent(spec)
        seats = {0: Entrant(spec, spec, "target", "")}
        try:
            return look(seats)
        except NoContest:  # there is no other agent, but the fault may be ours
            sandbox.close()

        def attempt(apart: Apart) -> Inspection:
            with _apart(seats, sandbox.limits, apart) as players:
                return players.inspect(0)

        try:
            return _attempt_apart(attempt)
        except Sabotage as culprit:
            return Inspection(fault=f"it did harm when it was looked at: {culprit.what}")

    return inspect


def _attempt_apart(
    attempt: Callable[[Apart], _Result],
    on_turn: Callable[[int], None] | None = None,
    disks: Mapping[str, Path] = MappingProxyType({}),
) -> _Result:
    """What comes of an attempt with agents apart, which is repeated where we failed ourselves.

    An agent in whose turn we stand still each time has done that; no process that it started runs on.
    """
    stalls: Counter[int] = Counter()
    failed, runs = 0, -1

    def begin_turn(seat: int) -> None:
        nonlocal runs
        runs = seat
        if on_turn is not None:
            on_turn(seat)

    apart = Apart(begin_turn, {"the disk of the agents' folders": Path(tempfile.gettempdir()), **disks})
    while True:
        try:
            with no_newcomers_left():
                return attempt(apart)
        except Sabotage:
            raise
        except Stalled as error:
            stalls[runs] += 1
            if stalls[runs] == len(_PAUSES_S):
                raise Sabotage(runs, f"{error}, each time, while no other agent ran") from None
            time.sleep(_PAUSES_S[stalls[runs]])
        except NoContest:
            failed += 1
            if failed == len(_PAUSES_S):
                raise
            time.sleep(_PAUSES_S[failed])


@contextmanager
def _isolated(entrants: Mapping[int, Entrant], sandbox: Sandbox) -> Iterator[IsolatedPlayers]:
    players = IsolatedPlayers(sandbox, entrants)
    try:
        yield players
    except BaseException:
        players.close()
        sandbox.close()  # whatever was under way, the next match starts anew
        raise
    players.close()
    sandbox.clear()
    if players.doubts and len(entrants) > 1:
        raise NoContest(f"{players.doubts[0]}; another agent may have done that")


@contextmanager
def _apart(entrants: Mapping[int, Entrant], limits: AgentLimits, apart: Apart) -> Iterator[ApartPlayers]:
    players = ApartPlayers(entrants, limits, apart.on_turn, apart.disks)
    try:
        yield players
    finally:
        players.close()
