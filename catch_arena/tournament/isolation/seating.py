"""Who sits where in a match, and in which process: the door of this room."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any, Final

from catch_arena.config import ArenaConfig
from catch_arena.errors import NoContest
from catch_arena.tournament.entrants import Entrant, Inspection, inspected, is_shipped
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.players import IsolatedPlayers
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match import MatchResult, play
from catch_arena.tournament.players import Players, Together, TrustedPlayers

_PAUSES_S: Final = (0.0, 1.0, 5.0)
"""How long we wait before a match that we failed to hold is begun again; then it is given up."""


@contextmanager
def seated(entrants: Sequence[Entrant], sandbox: Sandbox | None) -> Iterator[Players]:
    """These entrants, by seat, for one match: isolated in a sandbox, but for those that come with the package; all in
    this process without one.

    All that isolated agents started is ended afterwards. Raises: NoContest where they could not be held.
    """
    isolated = {seat: one for seat, one in enumerate(entrants) if sandbox is not None and not is_shipped(one.spec)}
    trusted = {seat: one for seat, one in enumerate(entrants) if seat not in isolated}
    if sandbox is None or not isolated:
        yield TrustedPlayers.of(trusted)
        return
    with _isolated(isolated, sandbox) as players:
        yield Together((TrustedPlayers.of(trusted), players)) if trusted else players


def sandboxed(limits: AgentLimits | None) -> AbstractContextManager[Sandbox | None]:
    """A sandbox with these limits; none where there are none, as all are trusted."""
    return nullcontext() if limits is None else Sandbox(limits)


def play_entrants(
    config: ArenaConfig, seed: int, entrants: Sequence[Entrant], sandbox: Sandbox | None, **options: Any
) -> MatchResult:
    """One match of these entrants, by seat; one that we failed to hold is played again, and at last given up.

    Args: `options`, those of `play`. Raises: OutputError; NoContest.
    """
    names = [entrant.name for entrant in entrants]
    pauses = iter(_PAUSES_S)
    while True:
        try:
            with seated(entrants, sandbox) as players:
                return play(config, seed, players, names, **options)
        except NoContest:
            pause = next(pauses, None)
            if pause is None:
                raise
            time.sleep(pause)


def inspector(sandbox: Sandbox | None) -> Callable[[str], Inspection]:
    """How `enter` looks at agents: in this process where it would play them here, else in processes of their own."""
    if sandbox is None:
        return inspected

    def inspect(spec: str) -> Inspection:
        if is_shipped(spec):
            return inspected(spec)
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
