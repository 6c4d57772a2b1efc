"""Measure how much of a game a scenario is: `python scripts/measure_game.py standard crowd --rounds 8`.

Prints, for each scenario, the share of catches that were contested (another hunter had the target as its active one
within the last second), the share with two requests for the target in the very same step, and the standings of each
side. A hunter that drives itself has no active target, so with such agents the first share is a lower bound.
"""

import argparse
import sys
from collections import deque
from dataclasses import dataclass, field, replace
from itertools import cycle, islice

from rich.console import Console

from catch_arena import CatchArenaError, Verdict, World, scenario
from catch_arena.cli.progress import progress_bar
from catch_arena.cli.tables import standings_tables
from catch_arena.envs.parallel import CatchArenaEnv
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.isolation.playing import play_entrants
from catch_arena.tournament.match import PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.statistics.standings import standings_of_sides

AGENTS = ("first", "nearest", "contested", "contested_by_time", "patrol", "intercept")
PREY_AGENTS = ("first", "flee", "corners", "contested_by_time", "patrol", "intercept", "random", "nearest")
"""Where there is prey: `flee` hunts as `nearest`, and `corners` as `contested`; those without a `Prey` play `flee`."""


@dataclass
class Contests:
    """Counts the catches of matches that it watches."""

    catches: int = 0
    contested: int = 0
    same_step: int = 0
    past: deque[World] = field(default_factory=deque)

    def watch(self, env: CatchArenaEnv) -> None:
        """One step's end."""
        world = env.world()
        if world.step == 0:
            self.past.clear()
        for ruling in world.rulings:
            if ruling.verdict is not Verdict.GRANTED:
                continue
            rivals = [other for other in world.rulings if other.hunter != ruling.hunter]
            asked = any(other.target == ruling.target for other in rivals)
            under_way = any(
                hunter.active_target == ruling.target
                for then in self.past
                for seat, hunter in enumerate(then.hunters)
                if seat != ruling.hunter
            )
            self.catches += 1
            self.contested += asked or under_way
            self.same_step += asked
        while self.past and self.past[0].time_ms <= world.time_ms - 1000:
            self.past.popleft()
        self.past.append(world)


def measure(name: str, agents: list[str] | None, rounds: int, seed: int) -> None:
    """Play a tournament in this process, and print what it says about the scenario."""
    config = scenario(name)
    parties = Parties.of(config)
    usual = PREY_AGENTS[: max(7, parties.group)] if config.prey else AGENTS
    entrants = enter(agents or usual)
    # where seats are many, the agents take several each
    players = list(islice(cycle(range(len(entrants))), max(len(entrants), parties.group)))
    plan = round_robin(len(players), parties, rounds, seed)
    contests = Contests()
    played: list[PlayedMatch] = []
    with progress_bar(name) as show:
        for match in plan:
            seating = [players[place] for place in match.seating]
            seated = [entrants[place] for place in seating]
            told = match.agent_seeds
            result = play_entrants(config, match.seed, seated, None, agent_seeds=told, watch=contests.watch)
            played.append(PlayedMatch(replace(match, seating=tuple(seating)), result))
            show(len(played), len(plan))
    share = 100 / max(1, contests.catches)
    print(f"{name}: {len(plan)} matches, {contests.catches / len(plan):.1f} catches in each")
    print(f"  contested      {contests.contested * share:5.1f} % of catches")
    print(f"  same step      {contests.same_step * share:5.1f} % of catches")
    for table in standings_tables(standings_of_sides(entrants, played, parties)):
        Console().print(table)


def main() -> int:
    """The exit code: 0, or 2 with a line that says why not."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenarios", nargs="+", help="their names")
    parser.add_argument("--agents", nargs="+", help="who plays; all are trusted, and play in here")
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    try:
        for name in args.scenarios:
            measure(name, args.agents, args.rounds, args.seed)
    except CatchArenaError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
