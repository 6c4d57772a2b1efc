"""Which agent of a match plays in which process: what the rest of the package uses of this folder."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from types import MappingProxyType
from typing import Any, Final

from catch_arena.config import ArenaConfig
from catch_arena.errors import NoContest
from catch_arena.tournament.entrants import Entrant, Inspection, inspect_agent, is_shipped
from catch_arena.tournament.isolation.isolated_players import IsolatedPlayers
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match import MatchResult, play
from catch_arena.tournament.players import AbsentPlayers, CompositePlayers, Fault, Players, TrustedPlayers

_PAUSES_S: Final = (0.0, 1.0, 5.0)
"""How long we wait before a match that we failed to hold is begun again; then it is given up."""


@contextmanager
def start_players(
    entrants: Sequence[Entrant] | Mapping[int, Entrant],
    sandbox: Sandbox | None,
    excluded: Mapping[int, str] = MappingProxyType({}),
) -> Iterator[Players]:
    """The players of one match, by seat, for as long as the context lasts; all that isolated agents started is ended
    with it.

    Entrants that do not come with the package are isolated in the `sandbox`, where there is one, and those that cannot
    begin are not started; nor are the `excluded`, seats with the reason why.

    Raises:
        NoContest: where they could not be held.
    """
    entrants = entrants if isinstance(entrants, Mapping) else dict(enumerate(entrants))
    faults = {seat: Fault("FORFEIT_INIT", one.fault) for seat, one in entrants.items() if one.fault is not None}
    faults |= {seat: Fault("FORFEIT_OUT", why) for seat, why in excluded.items()}
    started = {seat: one for seat, one in entrants.items() if seat not in faults}
    isolated = {seat: one for seat, one in started.items() if sandbox is not None and not is_shipped(one.spec)}
    trusted = {seat: one for seat, one in started.items() if seat not in isolated}
    with ExitStack() as stack:
        parts: list[Players] = []
        if trusted:
            parts.append(TrustedPlayers.of(trusted))
        if sandbox is not None and isolated:
            parts.append(stack.enter_context(_isolated(isolated, sandbox)))
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
    *,
    excluded: Mapping[int, str] = MappingProxyType({}),
    **options: Any,
) -> MatchResult:
    """One match of these entrants, by seat; one that we failed to hold is played again, and at last given up.

    Args:
        config: the arena's settings.
        seed: a whole number in [0, 2^64).
        entrants: who plays.
        sandbox: how agents that are not trusted run.
        excluded: as of `start_players`.
        options: those of `play`.

    Raises:
        OutputError: for a replay that cannot be written.
        NoContest: where the match could not be held.
    """
    names = [entrant.name for entrant in entrants]
    pauses = iter(_PAUSES_S)
    while True:
        try:
            with start_players(entrants, sandbox, excluded) as players:
                return play(config, seed, players, names, **options)
        except NoContest:
            pause = next(pauses, None)
            if pause is None:
                raise
            time.sleep(pause)


def inspector(sandbox: Sandbox | None) -> Callable[[str], Inspection]:
    """How `enter` looks at agents: in this process where it would play them here, else in processes of their own."""
    if sandbox is None:
        return inspect_agent

    def inspect(spec: str) -> Inspection:
        if is_shipped(spec):
            return inspect_agent(spec)
        entrant = Entrant(spec, spec, "target", "")
        with _isolated({0: entrant}, sandbox) as players:
            found = players.inspect()
            sandbox.end(entrant)
        return found

    return inspect


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
