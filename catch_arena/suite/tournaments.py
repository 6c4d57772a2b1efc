"""Tournaments of a suite: an agent plays one in each scenario, in a folder with the scenario's name."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from catch_arena.suite.contents import Suite
from catch_arena.tournament.agent_spec import is_shipped
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution.block_queue import do_here
from catch_arena.tournament.execution.executors import Worker, local_executor
from catch_arena.tournament.execution.runner import Setup
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match_loop import play_entrants
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.players import enter


def tournaments(suite: Suite, agent: Entrant, out: Path, blocks: int, quotas: Quotas | None) -> list[Setup]:
    """Return the tournament of an agent in each scenario; an opponent of the agent's name is called `nearest#2`.

    `out` is the folder of all agents; the agent's folder in it has its name, with `/` and `..` replaced. The quotas are
    those of an agent that does not come with the package; None if it is trusted.
    """
    folder = out / agent.name.replace("/", "-").replace("..", "__")
    setups = []
    for one in suite.scenarios:
        opponents = (replace(it, name=it.name + "#2" * (it.name == agent.name)) for it in enter(one.opponents))
        worker = Worker(one.config, (agent, *opponents), quotas=None if is_shipped(agent.spec) else quotas)
        setups.append(Setup(folder / one.name, suite.plan(one, blocks), worker, suite.secret(one)))
    return setups


def cannot_play(suite: Suite, agent: Entrant, sandbox: Sandbox | None) -> Iterator[tuple[str, str]]:
    """Yield the scenarios in which an agent fails at its first observation, and the reasons; no match is kept.

    An observation may be wider or narrower than in other arenas. `idle` plays all other parties.
    """
    (idle,) = enter(["idle"])
    for one in suite.scenarios:
        entrants = [agent] + [idle] * (len(Parties.of(one.config)) - 1)
        result = do_here(play_entrants, one.config, suite.seed, entrants, sandbox, most_steps=1)
        if (forfeit := result.forfeits[0]) is not None:
            yield one.name, forfeit.reason


def play(setups: Sequence[Setup], jobs: int, progress: Callable[[int, int], None]) -> None:
    """Play the tournaments of an agent one after the other, in this number of processes; begun ones are continued.

    `progress` is called with (matches played, matches of all tournaments) after each block.
    """
    before, matches = 0, sum(one.plan.size for one in setups)

    def show(played: int, _: int) -> None:
        progress(before + played, matches)

    with local_executor(setups[0].worker, jobs) as ready:
        for one in setups:
            ready.worker = one.worker
            with one.begin(resume=True) as store:
                one.play(store, ready, show)
            before += one.plan.size
