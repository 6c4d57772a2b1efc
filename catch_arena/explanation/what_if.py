"""Search for the smallest change of a loser's actions with which it would have won a contest ("what if").

docs/reference/replays.md defines the changes that are tried, and their order.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate, islice, pairwise, product
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.state import PART_NAMES
from catch_arena.engine import Engine, SavedState
from catch_arena.errors import ConfigError, require_type
from catch_arena.explanation.contests import contests_of
from catch_arena.explanation.facts import Claim, Contest
from catch_arena.explanation.formatting import seconds
from catch_arena.explanation.match_summary import explain
from catch_arena.explanation.seats import find_subjects, labels, prey_labels
from catch_arena.explanation.sentences import listed, margin_phrase
from catch_arena.explanation.step_explanation import step_at
from catch_arena.replay import Replay
from catch_arena.verdicts import Verdict
from catch_arena.world import World

_WINDOW_MS: Final = 2000
_PART_MS: Final = 100
"""Greatest duration of the parts of the window, in which an action is changed as a whole; at least one step."""
_MOST_DECISIONS: Final = 2
"""Greatest number of decisions that a change adds: one at its beginning, and one at its end."""
_QUARTERS: Final = tuple(quarter / 4.0 for quarter in range(-4, 5))
_MOST_OTHERS: Final = 8
"""Greatest number of other targets that are tried at a step, the nearest first."""
_CATCH: Final = PART_NAMES.index("catch")

Action = int | tuple[float, float] | dict[str, Any]
"""Action as an environment takes it: a rank, a command, or a dict of both under full control."""


@dataclass(frozen=True, slots=True)
class WhatIf:
    """Answer to a lost contest: the smallest change of the loser's actions with which it would have won the target."""

    contest: Contest
    seat: int
    """Seat of the loser."""
    actions: dict[int, Action]
    """Actions of the loser that replace the recorded ones, by the number of steps played before; empty if no change
    helps.
    """
    margin_um: int | None
    """Margin of the contest that it would have won, as in `Contest.margin_um`; None without a contest."""
    sentence: str
    """The answer in words."""
    alternative: Replay | None
    """Match with these actions, which ends with the step of the catch; None if no change helps."""


class _Change(NamedTuple):
    """Action in place of the recorded ones in a run of steps; None keeps a part as it was recorded."""

    run: range
    """Steps, from 0."""
    goal: int | None = None
    """Number of the target that is chosen or requested; 0 for none."""
    command: tuple[float | None, float | None] = (None, None)
    """Linear and angular velocity, as fractions of the limits."""


def what_if(
    replay: Replay,
    contest: Contest,
    hunter: int | str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> WhatIf:
    """Search for the smallest change of a loser's actions with which it would have won the contested target.

    All other agents keep their recorded actions. Actions change at most two seconds before the contest.

    Args:
        replay: the recorded match.
        contest: a contest of the match, from `explain(replay).contests`.
        hunter: the loser, as `explain` takes it; None for the nearest loser, of another team if there is one.
        progress: called with (steps of the search played, greatest number of these).

    Raises:
        ConfigError: for a contest that is not of this match, and a hunter that did not lose it.
        ReplayError: if the match does not play as recorded.
    """
    require_type("replay", replay, Replay, "Replay.load(path)")
    require_type("contest", contest, Contest, "lost_contest_at(replay, at_s)")
    claims = _lost(replay, contest, hunter)
    if not claims:
        loser = "a hunter" if hunter is None else hunter
        got = f"the one for {contest.target} at {seconds(contest.judged_ms)}"
        raise ConfigError(f"contest must be one that {loser} lost, got {got}")
    search = _Search(replay, contest, claims[0].seat)
    target = search.target
    change, name = search.find(progress), labels(replay.hunter_names)[search.seat]
    if change is None:
        sentence = f"No change of {name}'s actions within 2 s would have won {target}: {search.tried} were tried."
        return WhatIf(contest, search.seat, {}, None, sentence, None)
    alternative, last = search.alternative(change)
    won = next((one for one in contests_of(replay.config, last, replay.seed) if one.target == contest.target), None)
    if won is None:
        caught = f"catches {target} at {seconds(last.time_ms - replay.config.control_period_ms)} without a contest"
    else:
        caught = f"wins {target} at {seconds(won.judged_ms)} {margin_phrase(won)} ({won.clause})"
    sentence = f"{search.sentence(change)}, and {name} {caught}."
    margin_um = None if won is None else won.margin_um
    return WhatIf(contest, search.seat, search.actions(alternative), margin_um, sentence, alternative)


def lost_contest_at(replay: Replay, at_s: float, hunter: int | str | None = None) -> Contest:
    """Return the contest nearest to a time that a hunter lost.

    Args:
        replay: the recorded match.
        at_s: the time at which the contest was judged, to 0.05 s [s].
        hunter: the loser, as `explain` takes it; None for any.

    Raises:
        ConfigError: for a time outside the match or without such a contest, and a match without one.
        ReplayError: if the match does not play as recorded.
    """
    step_at(replay, at_s)
    contests = [contest for contest in explain(replay, hunter).contests if _lost(replay, contest, hunter)]
    whose = "" if hunter is None else f" by {hunter}"
    if not contests:
        raise ConfigError(f"the match must have a contest that was lost{whose}, and it has none")
    nearest = min(contests, key=lambda contest: abs(contest.judged_ms - 1000.0 * at_s))
    if abs(nearest.judged_ms - 1000.0 * at_s) > 50.0:
        raise ConfigError(
            f"at must be the time of a contest that was lost{whose}, got {at_s:g} s; "
            f"the nearest is at {seconds(nearest.judged_ms)}"
        )
    return nearest


def _lost(replay: Replay, contest: Contest, hunter: int | str | None) -> list[Claim]:
    """Return the claims of hunters with that name that lost a contest, in the contest's order."""
    seats, _ = find_subjects(replay, hunter)
    return [claim for claim in contest.claims if claim.verdict is Verdict.LOST_CONTEST and claim.seat in seats]


class _Search:
    """Search for one hunter in one contest: the states before it, and a batch of arenas that play changes."""

    def __init__(self, replay: Replay, contest: Contest, seat: int) -> None:
        config = replay.config
        self._replay, self._contest, self.seat = replay, contest, seat
        self._period_ms = config.control_period_ms
        self._control = config.controls[seat]
        self._number = int(contest.target.removeprefix(config.name_prefix))
        self._others = [other for other in range(config.hunters) if other != seat]
        self._judged = contest.step - 1
        self._first = max(0, self._judged - _WINDOW_MS // self._period_ms)
        self.tried = 0
        self._starts: dict[int, SavedState] = {}
        self._active: dict[int, NDArray[np.int64]] = {}
        """Numbers of the hunters' active targets, by seat, after a number of steps."""
        worlds = []
        for step, engine in enumerate(islice(replay.checked_engines(), contest.step + 1)):
            if step >= self._first - 1:
                self._starts[step] = engine.save(0)
                self._active[step] = engine.active_targets()[0]
            if step >= self._judged:
                worlds.append(engine.world())
        if len(worlds) < 2 or contest not in contests_of(config, worlds[1], replay.seed):
            raise ConfigError(f"contest must be one of explain(replay).contests, got {contest}")
        players = zip(worlds[0].prey, prey_labels(replay), strict=True)
        self.target = next((label for prey, label in players if prey.target == contest.target), contest.target)
        """Label of the contested target, or of the prey that plays it."""
        self._goals = {
            step: int(self._active[step + 1][seat]) if replay.choices[step][seat] else 0
            for step in range(max(0, self._first - 1), contest.step)
        }
        batch = _MOST_OTHERS + 2 if self._control == "target" else len(self._changes(range(0)))
        self._engine = Engine(config, batch)

    def find(self, progress: Callable[[int, int], None] | None) -> _Change | None:
        """Return the smallest change with which the hunter catches the target: that of the fewest decisions, of these
        the shortest, then the latest, then that of the least deviation; None if there is none.
        """
        part = max(1, _PART_MS // self._period_ms)
        edges = [*range(self._judged + 1, self._first, -part), self._first]
        most = 0 if self._control == "velocity" else _MOST_DECISIONS
        rounds = list(product(range(most + 1), range(1, len(edges))))
        # a run is played from its beginning to the contest
        steps = [sum(self._judged + 1 - begin for begin in edges[length:]) for _, length in rounds]
        for done, (decisions, length) in zip(accumulate(steps), rounds, strict=True):
            for stop, begin in zip(edges, edges[length:], strict=False):
                changes = [
                    change for change in self._changes(range(begin, stop)) if self._decisions(change) == decisions
                ]
                self.tried += len(changes)
                wins = self._wins(changes) if changes else {}
                if wins:
                    return min(wins, key=lambda change: self._deviation(change, wins[change]))
            if progress is not None:
                progress(done, sum(steps))
        return None

    def _goal(self, change: _Change, step: int) -> int:
        """Return the number of the target that a change chooses in a step; 0 for none."""
        return self._goals[step] if change.goal is None or step not in change.run else change.goal

    def _decisions(self, change: _Change) -> int:
        """Return the number of decisions that a change adds: steps in which the hunter chooses another target than in
        the step before.
        """
        chosen = [self._goal(change, step) for step in self._goals], self._goals.values()
        more, fewer = (sum(one != other for one, other in pairwise(goals)) for goals in chosen)
        return max(0, more - fewer)

    def _changes(self, run: range) -> list[_Change]:
        """Return the changes that are tried in a run; of equally large ones the first is best."""
        if self._control == "target":
            self._engine.restore(self._starts[run.start], 0)
            seen: list[int] = self._engine.numbers_seen(self.seat)[0].tolist()
            others = [number for number in seen if number not in (0, self._number)]
            return [_Change(run, goal) for goal in (self._number, *others[:_MOST_OTHERS], 0)]
        speeds = [speed for speed in _QUARTERS if speed >= 0.0 or self._replay.config.reverse]
        goals = (None, self._number) if self._control == "full" else (None,)
        commands = product((None, *speeds), (None, *_QUARTERS))
        return [_Change(run, goal, command) for goal, command in product(goals, commands)][1:]

    def _wins(self, changes: list[_Change]) -> dict[_Change, int]:
        """Return which changes of one run win the target, with the number of steps played until the catch."""
        wins: dict[_Change, int] = {}
        same = [*changes, *changes[-1:] * (self._engine.num_arenas - len(changes))]  # every arena plays a change
        for steps, (_, _, won) in enumerate(self._play(self._engine, same), start=changes[0].run.start + 1):
            wins |= {same[row]: steps for row in won}
        return wins

    def _play(
        self, engine: Engine, changes: Sequence[_Change]
    ) -> Iterator[tuple[NDArray[np.int64], NDArray[np.float32], list[int]]]:
        """Play changes in one run of steps, one in each arena of an engine, up to the contest; yield after each step
        all ranks and commands, and the arenas in which the hunter catches the contested target by a change that counts.

        A change counts if its target is in view in each step of the run, and the ranks of all other hunters mean the
        same targets as in the recorded match.
        """
        replay, seat, rows, run = self._replay, self.seat, len(changes), changes[0].run
        for row in range(rows):
            engine.restore(self._starts[run.start], row)
        counts = np.ones(rows, dtype=np.bool_)
        given = np.array([change.command for change in changes], dtype=np.float32)  # NaN for None
        for step in range(run.start, self._judged + 1):
            for agent, row in product(replay.withdrawn_before(step), range(rows)):
                engine.withdraw(row, agent)
            choices = np.tile(replay.choices[step], (rows, 1))
            commands = np.tile(replay.commands[step], (rows, 1, 1))
            wanted = np.array([self._goal(change, step) for change in changes])
            seen = engine.numbers_seen(seat) == wanted[:, None]
            in_view = seen.any(axis=1) & (wanted > 0)
            choices[:, seat] = np.where(in_view, seen.argmax(axis=1) + 1, 0)
            if step in run:
                counts &= in_view | ~np.array([bool(change.goal) for change in changes])
                commands[:, seat] = np.where(np.isnan(given), commands[:, seat], given)
            engine.step(choices, commands)
            active = engine.active_targets()[:, self._others]
            counts &= (active == self._active[step + 1][self._others]).all(axis=1)
            caught = np.flatnonzero(counts & (engine.parts[:, seat, _CATCH] > 0.0)).tolist()
            target_by_row = {
                row: {ruling.hunter: ruling.target for ruling in engine.world(row).rulings} for row in caught
            }
            yield choices, commands, [row for row in caught if target_by_row[row][seat] == self._contest.target]

    def _deviation(self, change: _Change, steps: int) -> float:
        """Return the sum of the differences from the recorded actions in a change's steps up to the catch: of both
        parts of the command, and 1 for another target.
        """
        total = 0.0
        for step in range(change.run.start, min(change.run.stop, steps)):
            recorded = self._replay.commands[step][self.seat].tolist()
            total += sum(abs(new - old) for new, old in zip(change.command, recorded, strict=True) if new is not None)
            total += change.goal not in (None, self._goals[step])
        return total

    def alternative(self, change: _Change) -> tuple[Replay, World]:
        """Return the match with a change, up to the step of the catch, and its last world."""
        old, begin = self._replay, change.run.start
        played, engine = old.copy(), Engine(old.config)
        for recorded in (played.choices, played.commands):
            del recorded[begin:]
        del played.digests[begin + 1 :]
        for choices, commands, won in self._play(engine, [change]):
            played.append(choices[0], commands[0], engine)
            if won:
                break
        played.withdrawals = [departure for departure in old.withdrawals if departure[0] < played.steps]
        played.named_requests = [request for request in old.named_requests if request.step < begin]
        return played, engine.world()

    def actions(self, alternative: Replay) -> dict[int, Action]:
        """Return the actions of the hunter that differ from the recorded ones, by step."""
        changed: dict[int, Action] = {}
        for step in range(self._first, alternative.steps):
            (rank, command), recorded = (
                (int(match.choices[step][self.seat]), tuple(match.commands[step][self.seat].tolist()))
                for match in (alternative, self._replay)
            )
            if (rank, command) != recorded:
                full = {"cmd_vel": command, "catch": rank}
                by_control: dict[str, Action] = {"target": rank, "velocity": command, "full": full}
                changed[step] = by_control[self._control]
        return changed

    def sentence(self, change: _Change) -> str:
        """Return a change in words."""
        run, config = change.run, self._replay.config
        begin, end, length = (seconds(steps * self._period_ms) for steps in (run.start, run.stop, len(run)))
        if self._control == "target":
            from_then_on = {self._goal(change, step) for step in range(run.start, self._judged + 1)}
            if from_then_on == {self._number}:
                return f"{length} earlier: head for {self.target} at {begin} instead of {end}"
            new, *old = (
                self.target if goal == self._number else config.target_name(goal) if goal else "no target"
                for goal in dict.fromkeys((change.goal or 0, *(self._goals[step] for step in run)))
            )
            return f"For {length} from {begin}: head for {new} instead of {listed(old)}"
        limits = np.array((config.max_speeds[self.seat], config.max_turn_rates[self.seat]))
        recorded = np.mean([self._replay.commands[step][self.seat] for step in run], axis=0) * limits
        (linear, angular), parts = change.command, []
        if linear is not None:
            parts.append(f"drive at {linear * limits[0]:.2f} m/s instead of {recorded[0]:.2f} m/s on average")
        if angular is not None:
            to, instead_of = (
                f"{'left' if rate > 0.0 else 'right'} at {abs(rate):.2f} rad/s"
                for rate in (angular * limits[1], recorded[1])
            )
            parts.append(f"turn {to} instead of {instead_of} on average")
        if change.goal is not None:
            parts.append(f"request {self.target}")
        return f"For {length} from {begin}: {listed(parts)}"
