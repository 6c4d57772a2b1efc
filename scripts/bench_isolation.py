"""Measure what isolation costs: standard matches of scripted agents in one process, and each in a process of its own.

CPU time is that of all processes: this one, the supervisor and the agents. So it does not matter how busy the machine
is. Reads /proc: for Linux.
"""

import argparse
import os
import platform
import time
from pathlib import Path

from catch_arena import agents, scenario
from catch_arena.descendants import family
from catch_arena.tournament.entrants import Entrant, enter
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.isolation.starting import inspector, start_players
from catch_arena.tournament.match import play

AGENTS = ("nearest", "contested", "contested_by_time", "patrol")


def cpu_seconds() -> float:
    """What this process, its descendants, and those that they have buried have used so far."""
    ticks = 0
    for pid in (os.getpid(), *family(os.getpid())):
        ticks += sum(map(int, Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[11:15]))
    return ticks / os.sysconf("SC_CLK_TCK")


def matches_per_cpu_second(entrants: tuple[Entrant, ...], sandbox: Sandbox | None, count: int) -> float:
    """PlayedMatch one after the other, with different seeds; the first one is not counted."""
    begin = 0.0
    for seed in range(count + 1):
        if seed == 1:
            begin = cpu_seconds()
        with start_players(entrants, sandbox) as players:
            play(scenario("standard"), seed, players, AGENTS)
    return count / (cpu_seconds() - begin)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--matches", type=int, default=10, help="of each kind, in each round")
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    print(f"standard matches per CPU-second of {', '.join(AGENTS)}")
    trusted = enter(AGENTS)
    with Sandbox() as sandbox:
        isolated = enter([str(Path(agents.__path__[0], f"{name}.py")) for name in AGENTS], inspector(sandbox))
        for _ in range(arguments.rounds):
            begin = time.perf_counter()
            apart = matches_per_cpu_second(isolated, sandbox, arguments.matches)
            elapsed = (time.perf_counter() - begin) / (arguments.matches + 1)
            together = matches_per_cpu_second(trusted, None, 5 * arguments.matches)
            print(f"trusted {together:6.2f}   isolated {apart:6.2f} ({elapsed:.2f} s a match by the clock)")


if __name__ == "__main__":
    main()
