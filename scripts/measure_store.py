"""What a tournament costs beside the play itself, and what a million matches would: docs/tournaments.md.

Measures the standard scenario with four scripted agents: a bare loop against the whole runner with its store, both in
this process; then a long tournament in several processes, its store and its exports; then the plan of a million.
"""

import argparse
import platform
import resource
import statistics
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from catch_arena import ArenaConfig, scenario
from catch_arena.cli.progress import progress_bar
from catch_arena.envs.parallel import CatchArenaEnv
from catch_arena.policy import Limits, View
from catch_arena.tournament.entrants import Entrant, enter
from catch_arena.tournament.execution.executors import Executor, ProcessExecutor, usable_cores
from catch_arena.tournament.execution.runner import play_plan
from catch_arena.tournament.execution.worker import Worker
from catch_arena.tournament.export import export
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import FixedPlan, round_robin
from catch_arena.tournament.store import STORE, Store, Tournament

AGENTS = ["nearest", "contested", "first", "patrol"]
TURNS = 7
MILLION = 1_000_000


@dataclass(frozen=True)
class Args:
    """The command line."""

    matches: int
    jobs: int


def parse() -> Args:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--matches", type=int, default=10_000)
    parser.add_argument("--jobs", type=int, default=usable_cores())
    return Args(**vars(parser.parse_args()))


def cpu_s(work: Callable[[], object]) -> float:
    """The CPU time of this process for some work [s]."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def bare(config: ArenaConfig, entrants: tuple[Entrant, ...], plan: FixedPlan) -> None:
    """The same matches without a runner: one env, the agents, nothing counted or kept."""
    for match in plan:
        env = CatchArenaEnv(config.replace(control=tuple(entrants[place].control for place in match.seating)))
        policies = [entrants[place].create() for place in match.seating]
        for policy, seed in zip(policies, match.agent_seeds, strict=True):
            policy.reset(seed)
        observations, infos = env.reset(seed=match.seed)
        limits = Limits.of(env.config, 0)
        while env.agents:
            actions = {}
            for agent, policy in zip(env.agents, policies, strict=True):
                mask = infos[agent].get("action_mask")
                view = View(observations[agent].tolist(), () if mask is None else mask.tolist(), limits)
                actions[agent] = policy.act(view)
            observations, _, _, _, infos = env.step(actions)


def measure_overhead(config: ArenaConfig, entrants: tuple[Entrant, ...], folder: Path) -> None:
    """Turn by turn, a bare loop and the runner."""
    plan = round_robin(len(entrants), Parties.of(config), 12, 0)
    worker = Worker(config, entrants)
    bare(config, entrants, plan)  # compiled
    times: dict[str, list[float]] = {"bare": [], "runner": []}
    for turn in range(TURNS):
        place = folder / str(turn)
        place.mkdir()
        times["bare"].append(cpu_s(lambda: bare(config, entrants, plan)))
        with Store.begin(Tournament(config, entrants, plan.parameters), place) as store, Executor(worker) as here:
            times["runner"].append(cpu_s(lambda: play_plan(store, plan, here)))
    loop, runner = (statistics.median(times[kind]) / plan.size for kind in ("bare", "runner"))
    print(f"a bare loop      {1000 * loop:.1f} ms of CPU a match")
    print(f"the runner       {1000 * runner:.1f} ms a match: {1 / runner:.1f} matches a second and core")
    print(f"its overhead     {100 * (runner - loop) / runner:.1f} % of the time")


def measure_length(config: ArenaConfig, entrants: tuple[Entrant, ...], folder: Path, args: Args) -> None:
    """A long tournament, its store and its exports."""
    plan = round_robin(len(entrants), Parties.of(config), args.matches // config.hunters, 0)
    facts = Tournament(config, entrants, plan.parameters)
    with Store.begin(facts, folder) as store:
        mine, wall = time.process_time(), time.perf_counter()
        with (
            ProcessExecutor(Worker(config, entrants), args.jobs) as workers,
            progress_bar("playing", plan.size) as show,
        ):
            play_plan(store, plan, workers, on_results=lambda _: show(store.count_played(), plan.size))
        mine, wall = time.process_time() - mine, time.perf_counter() - wall
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    theirs = used.ru_utime + used.ru_stime
    size = (folder / STORE).stat().st_size
    worker_s, collector_s, stored = theirs / plan.size, mine / plan.size, size / plan.size
    print(f"{plan.size} matches   {wall:.0f} s with {args.jobs} processes, {theirs / wall:.2f} cores busy in them")
    print(f"the workers      {1000 * worker_s:.1f} ms of CPU a match")
    print(f"the collector    {1000 * collector_s:.2f} ms: it keeps up with {worker_s / collector_s:.0f} cores")
    print(f"the store        {stored:.0f} bytes a match")
    print(f"a million        {MILLION * worker_s / 3600:.1f} core-hours, {MILLION * stored / 1e9:.2f} GB")
    with Store.read(folder) as store:
        for form in ("jsonl", "csv", "parquet"):
            path = folder / f"matches.{form}"
            spent = cpu_s(lambda form=form, path=path: export(store, form, path))
            written = path.stat().st_size
            print(f"export {form:<9} {1e6 * spent / plan.size:.0f} us and {written / plan.size:.0f} bytes a match")
        tracemalloc.start()
        played = list(store.played())
        held, _ = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        print(f"in memory        {held / len(played):.0f} bytes a match, as the standings hold them")
        print(f"reading it back  {1e6 * cpu_s(lambda: sum(1 for _ in store.played())) / plan.size:.0f} us a match")


def measure_plan(entrants: tuple[Entrant, ...], folder: Path) -> None:
    """A million duels planned, in a store."""
    config = scenario("duel")
    plan = round_robin(len(entrants), Parties.of(config), MILLION // 12, 0)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with Store.begin(Tournament(config, entrants, plan.parameters), folder) as store:
        spent = cpu_s(lambda: store.plan(plan.stage(0, ())))
        first = cpu_s(lambda: next(store.waiting()))
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    size = (folder / STORE).stat().st_size
    print(f"the plan of {plan.size}: {spent:.0f} s of CPU, {size / 1e6:.0f} MB, {grown / 1024:.0f} MB of memory more")
    print(f"its first block  {1000 * first:.1f} ms later")


def main() -> None:
    """All three; the yardstick says how slow the machine is, whose CPU time others may take."""
    args = parse()
    config, entrants = scenario("standard"), enter(AGENTS)
    print(f"{platform.machine()}, Python {platform.python_version()}, {usable_cores()} cores")
    print(f"a yardstick      ten million additions take {cpu_s(lambda: sum(range(10_000_001))):.2f} s here and now")
    with tempfile.TemporaryDirectory() as name:
        folders = [Path(name) / part for part in ("overhead", "length", "plan")]
        for folder in folders:
            folder.mkdir()
        measure_overhead(config, entrants, folders[0])
        measure_length(config, entrants, folders[1], args)
        measure_plan(entrants, folders[2])


if __name__ == "__main__":
    main()
