"""Measure what isolation costs: standard matches of scripted agents, trusted and isolated at each level, in turn.

CPU time is that of all processes: this one, bubblewrap and the agents. So it does not matter much how busy the
machine is. The first match, which starts the agents' processes, is measured by itself. Reads /proc: for Linux.
"""

import argparse
import os
import platform
from contextlib import ExitStack
from pathlib import Path
from statistics import median
from typing import get_args

from catch_arena import agents, scenario
from catch_arena.interrupts import family
from catch_arena.tournament.entrants import Entrant, enter
from catch_arena.tournament.isolation.limits import AgentLimits, Level
from catch_arena.tournament.isolation.playing import inspector, start_players
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match_loop import play

AGENTS = ("nearest", "contested", "contested_by_time", "patrol")


def cpu_seconds() -> float:
    """What this process, its descendants, and those that they have buried have used so far."""
    ticks = 0
    for pid in (os.getpid(), *family(os.getpid())):
        ticks += sum(map(int, Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[11:15]))
    return ticks / os.sysconf("SC_CLK_TCK")


def one_match(entrants: tuple[Entrant, ...], sandbox: Sandbox | None, seed: int) -> float:
    """The CPU seconds that a standard match took."""
    begin = cpu_seconds()
    with start_players(entrants, sandbox) as players:
        play(scenario("standard"), seed, players, AGENTS)
    return cpu_seconds() - begin


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--matches", type=int, default=10, help="of each kind, in each round")
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    print(f"standard matches per CPU-second of {', '.join(AGENTS)}")
    specs = [str(Path(agents.__path__[0], f"{name}.py")) for name in AGENTS]
    with ExitStack() as stack:
        kinds: dict[str, tuple[tuple[Entrant, ...], Sandbox | None]] = {"trusted": (enter(AGENTS), None)}
        one_match(*kinds["trusted"], 0)
        for level in get_args(Level):
            sandbox = stack.enter_context(Sandbox(AgentLimits(isolation=level)))
            kinds[level] = enter(specs, inspector(sandbox)), sandbox
            first = one_match(*kinds[level], 0)
            print(f"{level}: the first match, with the start of four processes, took {first:.2f} CPU-seconds")
        rates: dict[str, list[float]] = {kind: [] for kind in kinds}
        for _ in range(arguments.rounds):
            spent = dict.fromkeys(kinds, 0.0)
            for seed in range(1, arguments.matches + 1):  # in turn: what else the machine does hits all alike
                for kind, players in kinds.items():
                    spent[kind] += one_match(*players, seed)
            for kind, seconds in spent.items():
                rates[kind].append(arguments.matches / seconds)
            print("   ".join(f"{kind} {rate[-1]:6.2f}" for kind, rate in rates.items()), flush=True)
    print("   ".join(f"{kind} {median(rate):6.2f}" for kind, rate in rates.items()), "(medians)")
    ratios = [one / other for one, other in zip(rates["namespaces"], rates["processes"], strict=True)]
    print(f"namespaces / processes: {median(ratios):.3f} ({min(ratios):.3f} to {max(ratios):.3f})")


if __name__ == "__main__":
    main()
