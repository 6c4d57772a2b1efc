"""What agents say of themselves before they play."""

from collections.abc import Callable, Mapping

from catch_arena.errors import NoContest
from catch_arena.tournament.entrants import Entrant, Inspection, inspect_agent, is_shipped
from catch_arena.tournament.isolation.apart import Apart, Sabotage, attempt_apart, players_apart
from catch_arena.tournament.isolation.isolated_players import players_together
from catch_arena.tournament.isolation.sandbox import Sandbox


def inspector(sandbox: Sandbox | None) -> Callable[[str], Inspection]:
    """How `enter` looks at agents: in this process where it would play them here, else in processes of their own.

    One that harms what keeps it, whenever it is looked at, cannot play.
    """
    if sandbox is None:
        return inspect_agent

    def look(seats: Mapping[int, Entrant]) -> Inspection:
        with players_together(seats, sandbox) as players:
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
            with players_apart(seats, sandbox.limits, apart) as players:
                return players.inspect(0)

        try:
            return attempt_apart(attempt)
        except Sabotage as culprit:
            return Inspection(fault=f"it did harm when it was looked at: {culprit.what}")

    return inspect
