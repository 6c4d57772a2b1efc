"""Play a tournament of all shipped agents, then a final of the best four, and make its video in out/demo."""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from catch_arena import CatchArenaError, Replay, scenario
from catch_arena.render.video import render_replay
from catch_arena.tournament.display.tables import progress_bar, standings_table
from catch_arena.tournament.entrants import enter, shipped
from catch_arena.tournament.execution import executors, runner
from catch_arena.tournament.match import play
from catch_arena.tournament.plans import schedule
from catch_arena.tournament.records import results
from catch_arena.tournament.records.store import Tournament
from catch_arena.tournament.statistics.standings import standings

SCENARIO = "standard"


@dataclass(frozen=True)
class Args:
    """The command line."""

    out: Path
    rounds: int
    seed: int
    jobs: int


def parse() -> Args:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/demo"), help="the folder to write to")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--jobs", type=int, default=executors.usable_cores())
    return Args(**vars(parser.parse_args()))


def demo(args: Args) -> None:
    """A tournament, its table, the final and the video."""
    config = scenario(SCENARIO)
    results.prepare_folder(args.out)

    entrants = enter(list(shipped()))
    plan = schedule.round_robin(len(entrants), config.hunters, args.rounds, args.seed)
    print(f"{len(entrants)} agents play {len(plan)} matches of {config.time_limit_s:g} s on {args.jobs} cores")
    with progress_bar("playing", len(plan)) as show:
        played = runner.run(config, entrants, plan, jobs=args.jobs, progress=show)
    table = standings(entrants, played)
    results.write_standings(args.out, Tournament(config, entrants, plan.words), len(played), table)
    Console().print(standings_table(table))

    best = enter([line.name for line in table[: config.hunters]])
    names = [finalist.name for finalist in best]
    replay, video = args.out / "final.replay", args.out / "final.mp4"
    final = play(config, args.seed, [one.create() for one in best], names, title="The final", record=replay)
    print("the final: " + ", ".join(f"{name} {score}" for name, score in zip(names, final.scores, strict=True)))
    with progress_bar("rendering") as show:
        render_replay(Replay.load(replay), video, progress=show)
    print(f"results: {args.out / results.TABLE}")
    print(f"video:   {video}")


def main() -> int:
    """The exit code: 0, 2 with a line that says why not, or 130 after Ctrl-C."""
    try:
        demo(parse())
    except CatchArenaError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
