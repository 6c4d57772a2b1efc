"""Summary of a match, from the arbiter's evidence (R5.6): contests, refusals, captures, and each agent's results."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from catch_arena.config import ArbitrationPolicy
from catch_arena.explanation.captures import PreyRecord
from catch_arena.explanation.contests import contests_of
from catch_arena.explanation.facts import (
    Capture,
    Contest,
    HunterSummary,
    PreySummary,
    Refusals,
    TeamSummary,
    json_ready,
)
from catch_arena.explanation.seats import exit_cause, find_subjects, labels, prey_labels, team_label
from catch_arena.explanation.seen_targets import SeenTargets
from catch_arena.explanation.sentences import (
    capture_sentence,
    contest_sentence,
    no_contest_sentence,
    opening_sentence,
    prey_sentence,
    refusals_sentence,
    summary_sentence,
)
from catch_arena.replay import Replay
from catch_arena.verdicts import Ruling, Verdict
from catch_arena.world import World


@dataclass(frozen=True, slots=True)
class Explanation:
    """The contests and refusals of a match, and a summary of each hunter and each prey that it is about."""

    title: str
    policy: ArbitrationPolicy
    hunters_per_catch: int
    """Number of hunters of one team that a catch needs (R5.10)."""
    reaches_um: tuple[int, ...]
    """Reach of each hunter in micrometres, by seat (R2.7)."""
    steps: int
    duration_ms: int
    names: tuple[str, ...]
    """Labels of the hunters, by seat."""
    prey_names: tuple[str, ...]
    """Labels of the prey, by index."""
    prey_by_target: dict[str, str]
    """Label of the prey by the name of each target that it played."""
    scores: tuple[int, ...]
    contests: tuple[Contest, ...]
    refusals: tuple[Refusals, ...]
    records: tuple[HunterSummary, ...]
    teams: tuple[TeamSummary, ...]
    """Results of the teams; () if there are no teams."""
    captures: tuple[Capture, ...]
    """Captures of or by the prey and hunters that the explanation is about."""
    prey: tuple[PreySummary, ...]
    """Summaries of the prey that the explanation is about, by index."""

    def lines(self) -> list[str]:
        """Return the match in words: an opening line, the contests, runs of refusals and captures in order, and the
        summaries of the hunters and prey, with an empty line between these parts.
        """
        prey = self.prey_by_target
        events = [(fact.step, 0, contest_sentence(fact, self.names, prey.get(fact.target))) for fact in self.contests]
        events += [(run.first_step, 1, refusals_sentence(run, self)) for run in self.refusals]
        events += [(fact.step, 2, capture_sentence(fact, self)) for fact in self.captures]
        found = [text for _, _, text in sorted(events)]
        if not self.contests:
            found.append(no_contest_sentence(self))
        summaries = [*(summary_sentence(fact, self.policy) for fact in self.records), *map(prey_sentence, self.prey)]
        return [opening_sentence(self), "", *found, "", *summaries]

    def to_dict(self) -> dict[str, Any]:
        """Return JSON-ready values: verdicts by name, lots in hexadecimal digits, distances in micrometres."""
        found: dict[str, Any] = json_ready(self)
        return found


def explain(
    replay: Replay, hunter: int | str | None = None, progress: Callable[[int, int], None] | None = None
) -> Explanation:
    """Play a match again, and return its contests, refusals, captures and summaries.

    Args:
        replay: the recorded match.
        hunter: a seat, `prey_{index}`, or the name of an agent or a team, to explain only those; None for all.
        progress: called with (steps played, number of steps).

    Raises:
        ReplayError: if the match does not play as recorded.
        ConfigError: for an unknown hunter.
    """
    seats, prey_indices = find_subjects(replay, hunter)
    names = labels(replay.hunter_names)
    contests: list[Contest] = []
    refusals = _RefusalRuns()
    refused = [Counter[str]() for _ in names]
    summaries = [HunterSummary(seat, name) for seat, name in enumerate(names)]
    scores: tuple[int, ...] = ()
    prey = PreyRecord(replay)
    seen_in_match = _SeenInMatch(replay) if replay.config.partial_view else None
    before: World | None = None
    for step, world in enumerate(replay.worlds()):
        if seen_in_match is not None:
            seen_in_match.note(world, summaries)
        _note_departures(replay, world, summaries)
        prey.note(world)
        found = contests_of(replay, world)
        contests += found
        judged_ms = world.time_ms - replay.config.control_period_ms
        contested = {claim.seat for contest in found for claim in contest.claims}
        named = replay.named_rulings(before, world) if before is not None else []
        refusals.note(world.rulings, named, judged_ms, contested)
        _note_forestalled(world, found, summaries)
        for ruling in (*world.rulings, *named):
            if ruling.verdict not in (Verdict.GRANTED, Verdict.LOST_CONTEST):
                refused[ruling.hunter][ruling.verdict.name] += 1
        scores = tuple(hunter.score for hunter in world.hunters)
        before = world
        if progress is not None:
            progress(step, replay.steps)
    _count_contests(summaries, contests)
    for summary, score, tally in zip(summaries, scores, refused, strict=True):
        summary.catches, summary.refused = score, dict(sorted(tally.items()))
    own_names = {prey.summaries[index].name for index in prey_indices}
    own_targets = {target for target, name in prey.by_target.items() if name in own_names}
    return Explanation(
        title=replay.title,
        policy=replay.config.policy,
        hunters_per_catch=replay.config.hunters_per_catch,
        reaches_um=replay.config.reaches_um,
        steps=replay.steps,
        duration_ms=replay.duration_ms,
        names=names,
        prey_names=prey_labels(replay),
        prey_by_target=prey.by_target,
        scores=scores,
        contests=tuple(
            one for one in contests if one.target in own_targets or any(claim.seat in seats for claim in one.claims)
        ),
        refusals=tuple(one for one in refusals.found if one.target in own_targets or one.seat in seats),
        records=tuple(summaries[seat] for seat in seats),
        teams=_teams(replay, scores),
        captures=tuple(one for one in prey.captures if one.prey in prey_indices or one.seat in seats),
        prey=tuple(prey.summaries[index] for index in prey_indices),
    )


def _teams(replay: Replay, scores: Sequence[int]) -> tuple[TeamSummary, ...]:
    """R11.1: return the results of the teams, in the config's order."""
    teams = replay.config.teams or ()
    sums = [sum(scores[seat] for seat in seats) for seats in teams]
    return tuple(
        TeamSummary(team_label(replay, seats), seats, score, 1 + sum(rival_score > score for rival_score in sums))
        for seats, score in zip(teams, sums, strict=True)
    )


class _RefusalRuns:
    """Collector of refusals in runs: one at a time for a hunter's requests by rank, and one for each requested name."""

    def __init__(self) -> None:
        self.found: list[Refusals] = []
        self._running: dict[tuple[int, Verdict, object], Refusals] = {}

    def note(self, by_rank: Sequence[Ruling], by_name: Sequence[Ruling], judged_ms: int, contested: set[int]) -> None:
        """Add a step's refusals to runs. A catch or contest ends the hunter's runs."""
        busy = contested.union(ruling.hunter for ruling in by_rank if ruling.success)
        self._running = {key: run for key, run in self._running.items() if run.seat not in busy}
        for ruling in by_rank:
            if ruling.hunter not in busy:
                self._add(ruling, judged_ms, by_name=False)
        for ruling in by_name:
            self._add(ruling, judged_ms, by_name=True)

    def _add(self, ruling: Ruling, judged_ms: int, *, by_name: bool) -> None:
        target = None if ruling.target is None else str(ruling.target)
        key = (ruling.hunter, ruling.verdict, (target,) if by_name else "rank")
        run = self._running.get(key)
        if run is None or run.target != target:
            step = ruling.step + 1
            run = Refusals(ruling.hunter, ruling.verdict, step, step, judged_ms, judged_ms, target, by_name)
            self._running[key] = run
            self.found.append(run)
        run.times += 1
        run.last_step, run.last_ms = ruling.step + 1, judged_ms
        if (distance := ruling.distance_um) is not None:
            run.nearest_um = distance if run.nearest_um is None else min(run.nearest_um, distance)
            run.farthest_um = distance if run.farthest_um is None else max(run.farthest_um, distance)


class _SeenInMatch:
    """R7.5: names of the targets that each hunter has had in sight so far."""

    def __init__(self, replay: Replay) -> None:
        self._targets = SeenTargets(replay.config)
        self._seen: list[set[str]] = [set() for _ in replay.hunter_names]

    def note(self, world: World, summaries: Sequence[HunterSummary]) -> None:
        """Count the catches of never seen targets in the last step, and add the targets in sight now."""
        caught = [(str(ruling.target), ruling.hunter) for ruling in world.rulings if ruling.success]
        names = np.array([target.name for target in world.targets], dtype=object)
        for summary, seen in zip(summaries, self._seen, strict=True):
            missed = sum(catcher != summary.seat and name not in seen for name, catcher in caught)
            summary.never_seen = (summary.never_seen or 0) + missed
            if not world.hunters[summary.seat].withdrawn:
                seen.update(names[self._targets.of(world, summary.seat)].tolist())


def _note_departures(replay: Replay, world: World, summaries: Sequence[HunterSummary]) -> None:
    """R1.6, R1.7: note the departures in a step; a hunter that takes no part in it left at its beginning."""
    for summary, hunter in zip(summaries, world.hunters, strict=True):
        if hunter.withdrawn and summary.withdrawn_ms is None:
            summary.withdrawn_ms = world.time_ms - replay.config.control_period_ms
            summary.dropped_out = exit_cause(replay, summary.seat) == "dropped out"


def _note_forestalled(world: World, contests: Sequence[Contest], summaries: Sequence[HunterSummary]) -> None:
    """Count the hunters whose active target (R4.1) another hunter caught without a contest between them."""
    catchers = {ruling.target: ruling.hunter for ruling in world.rulings if ruling.success}
    contested = {(contest.target, claim.seat) for contest in contests for claim in contest.claims}
    for summary, hunter in zip(summaries, world.hunters, strict=True):
        goal = hunter.active_target
        if catchers.get(goal, summary.seat) != summary.seat and (goal, summary.seat) not in contested:
            summary.forestalled += 1


def _count_contests(summaries: Sequence[HunterSummary], contests: Sequence[Contest]) -> None:
    """Add to the summaries the numbers of contests won and lost, and the mean margins."""
    decided = [contest for contest in contests if contest.clause != "R9.1"]  # under R9.1 every claim wins
    for summary in summaries:
        won, lost = [], []
        for contest in decided:
            winner, *losers = contest.claims
            if winner.seat == summary.seat:
                won.append(contest.margin_um or 0)
            for claim in losers:
                if claim.seat == summary.seat:
                    summary.contests_lost_to_mates += claim.mate
                    lost.append((claim.distance_um or 0) - (winner.distance_um or 0))
        summary.contests_won, summary.contests_lost = len(won), len(lost)
        summary.won_by_um = sum(won) / len(won) if won else None
        summary.lost_by_um = sum(lost) / len(lost) if lost else None
