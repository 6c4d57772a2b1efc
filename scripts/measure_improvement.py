"""Measure what is left to gain for a trained agent: `python scripts/measure_improvement.py --matches 128`.

One step of policy improvement by rollouts (Tesauro and Galperin, "On-line policy improvement using Monte-Carlo search",
1996). The player goes where its network says, but every few steps it thinks: it copies the arena, and plays the copies
on for some seconds with the rivals that it really has; once as the network would, and once for each other *course* that
it could take first. It takes a course that does better by more than its noise. The targets to come are drawn for each
future, and are the same for all courses. Then the network alone plays the same matches.

The player sees the whole arena and knows who its rivals are, as no agent does: this tells how much there is to learn.
"""

import argparse
import sys
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from catch_arena import CatchArenaError, scenario
from catch_arena.agents import contested, contested_by_time, patrol
from catch_arena.batch_policy import BatchView
from catch_arena.cli.progress import progress_bar
from catch_arena.core import state
from catch_arena.core.controllers import CONTROLS
from catch_arena.engine.block_views import row_of
from catch_arena.engine.engine import Engine
from catch_arena.policy import Limits
from catch_arena.tournament.statistics.intervals import ratios
from catch_arena.training.destinations import destinations
from catch_arena.training.pointer import PointerNetwork, drive

CONFIG: Final = scenario("standard", control="velocity")
LIMITS: Final = Limits.of(CONFIG)
RIVALS: Final[tuple[Any, ...]] = (patrol.Agent(), contested_by_time.Agent(), contested.Agent())

KIND, X, Y, LEFT, FAMILY = range(5)
"""Courses are tables of these, (5, N) or (5, N, C): the kind; x and y of a place in the arena [m], or a speed and a
turn rate as parts of the limits; for how many steps it still holds; and where in FAMILIES it comes from.
"""
NONE, NETWORK, TARGET, REST, PASS, DRIVE = range(-1, 5)
"""Kinds: none; as the network says; to a target; to rest at a place; through a point; at fixed velocities."""
FAMILIES: Final = ("network", "now", "places", "beside", "around", "between", "velocities")
"""As the network says; what is under way; its next best two places; the points beside its target from which that is
within reach; points around; the middle between a rival and its nearest target; velocities.
"""
HELD_STEPS: Final = (0, 0, 10, 20, 8, 10, 4)
"""For how long a course of each family holds at most."""
DECISION_STEPS: Final = 3
"""For how long the network's decision holds in the futures. In the match it decides in each step."""
MOST_COPIES: Final = 2048
"""At a time: more do not fit into a processor's caches."""


class Arenas:
    """N arenas in lockstep, in each of which the player (who 0) and `RIVALS` (1 to 3) hunt."""

    def __init__(self, count: int) -> None:
        self.engine = Engine(CONFIG, count, with_infos=False, any_control=True)
        self.fields = self.engine.blocks.reshape(len(self.engine.blocks), -1, state.LANES)
        self.rows, self.seats = np.arange(count), np.zeros((count, 4), np.int64)
        self.choices, self.commands = np.zeros((count, 4), np.int64), np.zeros((count, 4, 2), np.float32)

    def seat(self, seats: Any) -> None:
        """Who sits where: (N, 4)."""
        self.seats = seats
        self.engine.controls[:] = CONTROLS["velocity"]
        self.engine.controls[self.rows[:, None], seats[:, 2:]] = CONTROLS["target"]

    def seen_by(self, who: int) -> BatchView:
        """What the player or a rival sees."""
        at = self.rows, self.seats[:, who]
        return BatchView(self.engine.observations[at], self.engine.masks[at], LIMITS)

    def step(self, own: Any) -> None:
        """One step: the player's velocities, (N, 2), and what the rivals do."""
        self.commands[self.rows, self.seats[:, 0]] = own
        for who, rival in enumerate(RIVALS, start=1):
            actions = self.commands if isinstance(rival, patrol.Agent) else self.choices
            actions[self.rows, self.seats[:, who]] = rival.act_batch(self.seen_by(who))
        self.engine.step(self.choices, self.commands)

    def scores(self) -> Any:
        """Catches, (N, 4), by who."""
        rows = [row_of(state.seat_at(seat) + state.SCORE) for seat in range(4)]
        by_seat = self.fields[:, rows].transpose(0, 2, 1).reshape(-1, 4)[: len(self.rows)]
        return np.take_along_axis(by_seat, self.seats, axis=1)

    def take(self, other: "Arenas", rows: Any, seeds: Any) -> None:
        """Become copies of another's arenas, (N,), with these seeds of what is to come, (2, N), if there are any."""
        self.seat(other.seats[rows])
        block, lane = np.divmod(self.rows, state.LANES)
        self.fields[block, :, lane] = other.fields[rows // state.LANES, :, rows % state.LANES]
        if seeds is not None:
            self.fields[block, row_of(state.SEED_HIGH), lane], self.fields[block, row_of(state.SEED_LOW), lane] = seeds
        for section in ("observations", "masks", "ends"):
            getattr(self.engine, section)[:] = getattr(other.engine, section)[rows]


copies: Final = cache(Arenas)
"""Arenas for futures; their memory is used again."""


class Player:
    """A network, and what would do better."""

    def __init__(self, options: argparse.Namespace) -> None:
        self.options, self.network = options, PointerNetwork.load(options.network)
        self.rng = np.random.default_rng((options.seed, 1))
        others = (1 - options.patrol) / 2
        self.weights = np.array([1.0, -options.patrol, -others, -others])
        self.runners_up: list[Any] = []
        """Of each thought: the family of the course that was best in the first futures, and what it gained in the
        second ones, beside going on as before: a mean and a standard error, (3, N).
        """

    def play(self, seats: Any, seeds: Any, *, thinks: bool) -> Any:
        """The catches in matches with these seats, (M, 4), and seeds, (M,): (M, 4), by who."""
        arenas, now = Arenas(len(seats)), np.zeros((5, len(seats)))
        arenas.engine.reset(seeds)
        arenas.seat(seats)
        with progress_bar("thinks" if thinks else "alone") as show:
            for step in range(CONFIG.max_steps):
                view = arenas.seen_by(0)
                if thinks and step % self.options.every == 0:
                    now = self.think(arenas, view, now, step)
                arenas.step(velocities(view, now, follow(view, now), self.goals(view, 1)[:, :, 0]))
                show(step + 1, CONFIG.max_steps)
        return arenas.scores()

    def goals(self, view: BatchView, count: int) -> Any:
        """Courses to the network's best places, best first: (5, N, count)."""
        parts = []
        for rows in np.array_split(np.arange(len(view.observations)), -(-len(view.observations) // 128)):
            seen = view.of(rows)
            found = destinations(seen)
            best = np.argsort(-self.network(found)[0], axis=1, kind="stable")[:, :count]
            legal, *points = (np.take_along_axis(one, best, axis=1) for one in (found.legal, found.forward, found.left))
            kinds = np.where(legal, np.where(best < found.places, REST, TARGET), NONE)
            parts.append(courses("places", kinds, *to_arena(seen, *points)))
        return np.concatenate(parts, axis=1)

    def think(self, arenas: Arenas, view: BatchView, now: Any, step: int) -> Any:
        """The courses to take from now on: (5, N)."""
        options, rows = self.options, arenas.rows
        steps, going_on = min(options.steps, CONFIG.max_steps - step), np.where(now[KIND] == NETWORK, 0, 1)
        under_way = np.where(now[KIND] == NETWORK, NONE, now[KIND])
        tables = [np.zeros((5, len(rows), 1)), np.stack((under_way, *now[X:]))[:, :, None]]
        best = self.goals(view, 3)
        ways = np.concatenate((*tables, *(others(name, view, best) for name in options.courses.split(","))), axis=2)
        worth = self.futures(arenas, ways, options.first, steps)
        gain = worth - worth[rows, :, going_on][..., None]  # (N, F, C)
        order = np.where(ways[KIND] == NONE, -np.inf, gain.mean(axis=1))
        order[rows, going_on] = np.inf
        finalists = np.argsort(-order, axis=1, kind="stable")[:, :3]  # the first of them is going on as before
        gain, ways = np.take_along_axis(gain, finalists[:, None], axis=2), ways[:, rows[:, None], finalists]
        if options.second:
            worth = self.futures(arenas, ways, options.second, steps)
            more = worth - worth[..., :1]
            self.runners_up.append(
                np.stack((ways[FAMILY, :, 1], more[..., 1].mean(axis=1), standard_error(more[..., 1])))
            )
            gain = np.concatenate((gain, more), axis=1)
        score = gain.mean(axis=1) - options.noise * standard_error(gain)
        score[ways[KIND] == NONE] = -np.inf
        return ways[:, rows, score.argmax(axis=1)]

    def futures(self, arenas: Arenas, ways: Any, count: int, steps: int) -> Any:
        """What each course, (5, N, C), is worth [catches] in each future: (N, count, C)."""
        _, players, width = ways.shape
        seeds = self.rng.integers(0, 2**32, (2, players, count))
        at_once, worth = max(1, MOST_COPIES // (count * width)), []
        for some in np.split(arenas.rows, arenas.rows[at_once::at_once]):
            shape = len(some), count, width
            who = np.broadcast_to(some[:, None, None], shape).reshape(-1)
            now = ways[:, who, np.broadcast_to(np.arange(width), shape).reshape(-1)]
            now[KIND] = np.maximum(now[KIND], NETWORK)
            there = copies(len(who))
            drawn = np.repeat(seeds[:, some].reshape(2, -1), width, axis=1)
            there.take(arenas, who, None if self.options.known else drawn)
            before, goal = there.scores(), np.zeros((5, len(who)))
            for step in range(steps):
                view, on_course = there.seen_by(0), now[KIND] != NETWORK
                points = follow(view, now)
                anew = (now[KIND] == NETWORK) & (on_course | (step % DECISION_STEPS == 0))
                if anew.any():
                    goal[:, anew] = self.goals(view.of(anew), 1)[:, :, 0]
                there.step(velocities(view, now, points, goal))
            worth.append(((there.scores() - before) @ self.weights).reshape(shape))
        return np.concatenate(worth)


def courses(name: str, kind: Any, x: Any, y: Any) -> Any:
    """Courses of one family: (5, N, C)."""
    family = FAMILIES.index(name)
    return np.stack(np.broadcast_arrays(kind, x, y, HELD_STEPS[family], family)).astype(np.float64)


def others(name: str, view: BatchView, best: Any) -> Any:
    """The courses of one family, beside the network's `best` places: (5, N, C)."""
    targets, rivals = view.targets, view.rivals
    kind: Any = PASS
    if name == "places":
        return best[:, :, 1:]
    if name == "velocities":
        speed, turn = (np.tile(table.reshape(-1), (len(view.masks), 1)) for table in np.mgrid[0:1:3j, -1:1:5j])
        return courses(name, DRIVE, speed, turn)
    if name == "around":
        angles = np.tile(np.arange(8) * np.pi / 4, (len(view.masks), 1))
        forward, left = 1.5 * np.cos(angles), 1.5 * np.sin(angles)
    elif name == "beside":
        ahead, aside = (table[:, None] for table in to_own(view, best[X, :, 0], best[Y, :, 0]))
        off = np.array([-0.75, 0.75]) * LIMITS.reach_m / np.maximum(1e-6, np.hypot(ahead, aside))
        forward, left, kind = (
            ahead - aside * off,
            aside + ahead * off,
            np.where(best[KIND, :, :1] == TARGET, PASS, NONE),
        )
    else:
        away = [getattr(targets, axis)[:, None] - getattr(rivals, axis)[..., None] for axis in ("forward", "left")]
        nearest = np.where(targets.present[:, None] > 0, np.hypot(*away), np.inf).argmin(axis=2)[..., None]
        half_way = [np.take_along_axis(table, nearest, axis=2)[..., 0] / 2 for table in away]
        forward, left = rivals.forward + half_way[0], rivals.left + half_way[1]
        kind = np.where(targets.present[:, :1] > 0, PASS, NONE)
    x, y = to_arena(view, forward, left)
    outside = (np.minimum(x, y) < 0) | (np.maximum(x, y) > CONFIG.side_m)
    return courses(name, np.where(outside, NONE, kind), x, y)


def to_arena(view: BatchView, forward: Any, left: Any) -> tuple[Any, Any]:
    """Points of the own frame, (N, C) each, in the arena [m]."""
    x, y, cosine, sine = (view.observations[:, column, None].astype(np.float64) for column in range(4))
    return x + cosine * forward - sine * left, y + sine * forward + cosine * left


def to_own(view: BatchView, x: Any, y: Any) -> tuple[Any, Any]:
    """And back: (N,) each."""
    own_x, own_y, cosine, sine = view.observations.T[:4].astype(np.float64)
    return cosine * (x - own_x) + sine * (y - own_y), cosine * (y - own_y) - sine * (x - own_x)


def follow(view: BatchView, now: Any) -> tuple[Any, Any]:
    """Where courses, (5, N), lead in the own frame: (N,) each. Those that are at an end become the network's."""
    forward, left = to_own(view, now[X], now[Y])
    away, chasing = np.hypot(forward, left), np.flatnonzero(now[KIND] == TARGET)
    targets = view.of(chasing).targets
    off = np.hypot(targets.forward - forward[chasing, None], targets.left - left[chasing, None])
    over = ((now[KIND] == PASS) & (away < 0.2)) | (now[LEFT] <= 0)
    gone = ~((targets.present > 0) & (off < 0.02)).any(axis=1)  # positions are float32
    over[chasing] |= gone | (away[chasing] < 0.999 * LIMITS.reach_m)  # or as good as caught
    now[KIND, over] = NETWORK
    now[LEFT] -= 1
    return forward, left


def velocities(view: BatchView, now: Any, points: tuple[Any, Any], goal: Any) -> Any:
    """What the player drives, (N, 2), to the points of its courses, or to the network's goals, (5, N)."""
    alone = now[KIND] == NETWORK
    forward, left = (
        np.where(alone, its, mine) for its, mine in zip(to_own(view, goal[X], goal[Y]), points, strict=True)
    )
    driven = drive(forward, left, np.where(alone, goal[KIND], now[KIND]) == REST, LIMITS)
    return np.where((now[KIND] == DRIVE)[:, None], now[[X, Y]].T, driven)


def standard_error(values: Any) -> Any:
    """Of the mean over futures: (N, F, ...) to (N, ...)."""
    futures = values.shape[1]
    return values.std(axis=1, ddof=1) / futures**0.5 if futures > 1 else np.zeros_like(values[:, 0])


def figure(values: Any) -> str:
    """A mean with its 95 % interval; each value is a block."""
    mean = ratios(values[:, None].astype(np.float64), np.ones((len(values), 1)))[0]
    return f"{mean.mean:.2f} ({mean.low:.2f} to {mean.high:.2f})"


def measure(options: argparse.Namespace) -> None:
    """Play, and print what was found."""
    rng, player = np.random.default_rng((options.seed, 0)), Player(options)
    seats = np.array([np.roll([0, *rng.permutation([1, 2, 3])], match) for match in range(options.matches)])
    seats, seeds = seats.argsort(axis=1), rng.integers(0, 2**63, options.matches).astype(np.uint64)
    figures: list[Any] = []
    for thinks in (False, True):
        scores = player.play(seats, seeds, thinks=thinks)
        most = scores == scores.max(axis=1, keepdims=True)
        shares = 100 * np.where(most[:, 0], 1 / most.sum(axis=1), 0.0)
        figures.append((shares, scores[:, 0] - scores[:, 1]))
    figures.append((figures[1][0] - figures[0][0], figures[1][1] - figures[0][1]))
    print(options)
    for name, (shares, lead) in zip(("alone", "thinks", "gain"), figures, strict=True):
        print(f"{name:7} wins {figure(shares)} %, ahead of patrol by {figure(lead)}")
    family, gain, error = np.concatenate(player.runners_up, axis=1) if options.second else np.zeros((3, 0))
    for place in np.unique(family):
        own = family == place
        print(
            f"best other course: {FAMILIES[int(place)]:10} {100 * own.mean():3.0f} % of thoughts, gains "
            f"{figure(gain[own])} catches, by more than twice its noise in {100 * (gain > 2 * error)[own].mean():.1f} %"
        )


def parse_options(arguments: list[str]) -> argparse.Namespace:
    """The command line's."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    say = parser.add_argument
    say("--network", type=Path, default=Path(__file__).parents[1] / "agents" / "ppo_destination.npz")
    say("--courses", default="places,beside", help=f"what else it could do: some of {', '.join(FAMILIES[2:])}")
    say("--matches", type=int, default=128)
    say("--seed", type=int, default=1)
    say("--every", type=int, default=6, help="steps from one thought to the next")
    say("--steps", type=int, default=40, help="how far it looks")
    say("--first", type=int, default=8, help="futures in which all courses are tried")
    say("--second", type=int, default=16, help="further futures, for the best three; 0: none")
    say("--noise", type=float, default=1.0, help="by how many standard errors a course has to be better")
    say("--patrol", type=float, default=0.6, help="weight of patrol's catches; those of the others share the rest")
    say("--known", action="store_true", help="it knows the targets to come, so that one future is enough")
    options = parser.parse_args(arguments)
    if unknown := set(options.courses.split(",")) - set(FAMILIES[2:]):
        parser.error(f"--courses must be some of {', '.join(FAMILIES[2:])}, got {', '.join(sorted(unknown))}")
    return options


if __name__ == "__main__":
    try:
        measure(parse_options(sys.argv[1:]))
    except CatchArenaError as error:
        sys.exit(str(error))
