"""Summary of a match, from the arbiter's evidence (R5.6): contests, refusals, captures, and each agent's results."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final

from catch_arena.config import ArbitrationPolicy
from catch_arena.explanation.contests import contests_of
from catch_arena.explanation.facts import (
    Capture,
    Catch,
    Contest,
    HunterSummary,
    PreySummary,
    Refusals,
    TeamSummary,
    json_ready,
)
from catch_arena.explanation.formatting import metres, seconds
from catch_arena.explanation.seats import exit_cause, find_subjects, labels, prey_labels, team_label, with_seat
from catch_arena.explanation.sentences import (
    contest_sentence,
    listed,
    prey_sentence,
    request_phrase,
    summary_sentence,
    target_label,
)
from catch_arena.replay import Replay
from catch_arena.text import counted
from catch_arena.verdicts import Ruling, Verdict
from catch_arena.world import World

_CONTEST_RULES: Final[dict[ArbitrationPolicy, str]] = {
    "nearest": "Contests go to the nearest hunter (R5.4)",
    "first_come": "Contests go to the hunter with the lowest lot of the step (R5.9)",
    "capstone": "The capstone's service grants every request (R9.1)",
}


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
    entrants: tuple[str, ...]
    """Names of the agents of each contender, which are the same in all matches."""
    catches: tuple[Catch, ...]
    """All catches of the match."""
    contests: tuple[Contest, ...]
    refusals: tuple[Refusals, ...]
    records: tuple[HunterSummary, ...]
    teams: tuple[TeamSummary, ...]
    """Results of the teams; () if there are no teams."""
    captures: tuple[Capture, ...]
    """Captures of or by the prey and hunters that the explanation is about."""
    prey: tuple[PreySummary, ...]
    """Summaries of the prey that the explanation is about, by index."""

    @property
    def contenders(self) -> dict[str, int]:
        """Final score of each contender by its label: of the teams, or of the hunters if there are no teams."""
        return {team.name: team.score for team in self.teams} or dict(zip(self.names, self.scores, strict=True))

    def lines(self) -> list[str]:
        """Return the match in words: an opening line, the contests, runs of refusals and captures in order, and the
        summaries of the hunters and prey, with an empty line between these parts.
        """
        events = [(fact.step, 0, self.sentence(fact)) for fact in self.contests]
        events += [(run.first_step, 1, self.sentence(run)) for run in self.refusals]
        events += [(fact.step, 2, self.sentence(fact)) for fact in self.captures]
        found = [text for _, _, text in sorted(events)]
        if not self.contests:
            found.append("No contest.")
        summaries = [*(summary_sentence(fact, self.policy) for fact in self.records), *map(prey_sentence, self.prey)]
        return [self._opening(), "", *found, "", *summaries]

    def sentence(self, fact: Contest | Refusals | Capture) -> str:
        """Return one contest, run of refusals or capture in words."""
        if isinstance(fact, Contest):
            return contest_sentence(fact, self.names, self.prey_by_target.get(fact.target))
        return self._refusals(fact) if isinstance(fact, Refusals) else self._capture(fact)

    def _opening(self) -> str:
        """Return the length of the match, its rule for contests, and the catches of each team and hunter, in words."""
        heading = f"{self.title}: " if self.title else ""
        sums = [f"{team.name} {team.score}" for team in sorted(self.teams, key=lambda team: -team.score)]
        of_teams = f"Teams (R11.1): {listed(sums)}. " if sums else ""
        length = f"{counted(self.steps, 'step')}, {seconds(self.duration_ms)}"
        caught = zip(self.names, self.scores, strict=True)
        catches = listed(f"{with_seat(name, seat)} {score}" for seat, (name, score) in enumerate(caught))
        needed = f"A catch needs {self.hunters_per_catch} hunters of one team (R5.10). "
        rules = f"{_CONTEST_RULES[self.policy]}. {needed if self.hunters_per_catch > 1 else ''}"
        return f"{heading}{length}. {rules}{of_teams}Catches: {catches}."

    def _refusals(self, run: Refusals) -> str:
        """Return one run of refusals in words: times, hunter, target and reason."""
        until = f"until {seconds(run.last_ms)} (step {run.last_step})"
        times = f" {run.times} times {until}" if run.times > 1 else ""
        phrase = request_phrase(
            run.target,
            run.verdict,
            (run.nearest_um, run.farthest_um),
            self.reaches_um[run.seat],
            by_name=run.by_name,
            prey=self.prey_by_target.get(run.target or ""),
        )
        when = f"At {seconds(run.first_ms)} (step {run.first_step})"
        return f"{when} {self.names[run.seat]} asked{times} for {phrase}."

    def _capture(self, capture: Capture) -> str:
        """Return one capture of prey in words: the hunter, the distance, and the time of the return."""
        after = "; it did not return"
        if capture.returned_ms is not None:
            after = f"; it returned at {seconds(capture.returned_ms)} as {capture.returned_as}"
        hunter, prey = self.names[capture.seat], self.prey_names[capture.prey]
        place = "" if capture.distance_um is None else f", from {metres(capture.distance_um)}"
        event = f"{hunter} caught {target_label(capture.target, prey)}{place}"
        when = f"At {seconds(capture.judged_ms)} (step {capture.step})"
        return f"{when} {event}, after {seconds(capture.in_play_ms)} in play{after} (R12.3)."

    def to_dict(self) -> dict[str, Any]:
        """Return JSON-ready values: verdicts by name, lots in hexadecimal digits, distances in micrometres."""
        found: dict[str, Any] = json_ready(asdict(self))
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
    catches: list[Catch] = []
    hunters = [_HunterRecord(replay, seat, name) for seat, name in enumerate(names)]
    prey = [_PreyRecord(index, name) for index, name in enumerate(prey_labels(replay))]
    scores = (0,) * len(names)
    for before, after, by_name in replay.judged_steps():
        found = contests_of(replay.config, after, replay.seed)
        granted = [ruling for ruling in after.rulings if ruling.success]
        contests += found
        catches += [Catch(before.time_ms, ruling.hunter, after.team_scores) for ruling in granted]
        catchers = {str(ruling.target): ruling.hunter for ruling in granted}
        for hunter_record in hunters:
            hunter_record.note(before, after, catchers, found)
        for prey_record in prey:
            prey_record.note(before, after)
        for ruling in after.rulings:
            hunters[ruling.hunter].add_request(ruling, before.time_ms, by_name=False)
        for ruling in by_name:
            hunters[ruling.hunter].add_request(ruling, before.time_ms, by_name=True)
        scores = tuple(state.score for state in after.hunters)
        if progress is not None:
            progress(after.step, replay.steps)
    own_targets = {target for index in prey_indices for target in prey[index].targets}
    refusals = sorted((run for record in hunters for run in record.refusals), key=lambda run: run.first_step)
    captures = sorted((one for record in prey for one in record.captures), key=lambda one: (one.step, one.prey))
    players, teams = replay.hunter_names, replay.config.team_seats
    return Explanation(
        title=replay.title,
        policy=replay.config.policy,
        hunters_per_catch=replay.config.hunters_per_catch,
        reaches_um=replay.config.reaches_um,
        steps=replay.steps,
        duration_ms=replay.duration_ms,
        names=names,
        prey_names=tuple(record.summary.name for record in prey),
        prey_by_target={target: record.summary.name for record in prey for target in record.targets},
        scores=scores,
        entrants=tuple(" + ".join(dict.fromkeys(players[seat] for seat in members)) for members in teams),
        catches=tuple(catches),
        contests=tuple(
            one for one in contests if one.target in own_targets or any(claim.seat in seats for claim in one.claims)
        ),
        refusals=tuple(one for one in refusals if one.target in own_targets or one.seat in seats),
        records=tuple(hunters[seat].finished(scores[seat], contests) for seat in seats),
        teams=tuple(
            TeamSummary(team_label(replay, members), members, sum(scores[seat] for seat in members))
            for members in replay.config.teams or ()
        ),
        captures=tuple(one for one in captures if one.prey in prey_indices or one.seat in seats),
        prey=tuple(prey[index].summary for index in prey_indices),
    )


class _HunterRecord:
    """Summary and refusals of one hunter, collected step by step."""

    def __init__(self, replay: Replay, seat: int, name: str) -> None:
        self._replay = replay
        self._summary = HunterSummary(seat, name)
        self._verdicts: Counter[Verdict] = Counter()
        """Number of its requests by verdict."""
        self._busy = False
        """True if the hunter was in a contest, or caught a target, in the last step."""
        self._running: dict[tuple[Verdict, str | None, bool], Refusals] = {}
        self.refusals: list[Refusals] = []

    def note(self, before: World, after: World, catchers: Mapping[str, int], contests: Sequence[Contest]) -> None:
        """Add the next step, with the seat that caught each target in it, and its contests."""
        summary, seat = self._summary, self._summary.seat
        if after.hunters[seat].withdrawn and summary.withdrawn_ms is None:  # R1.6, R1.7: it took no part in the step
            summary.withdrawn_ms = before.time_ms
            summary.out = exit_cause(self._replay, seat)
        lost = {target for target, catcher in catchers.items() if catcher != seat}
        contested = {one.target for one in contests if any(claim.seat == seat for claim in one.claims)}
        summary.forestalled += after.hunters[seat].active_target in lost - contested  # R4.1
        self._busy = bool(contested) or seat in catchers.values()
        if self._busy:
            self._running.clear()

    def add_request(self, ruling: Ruling, judged_ms: int, *, by_name: bool) -> None:
        """Add a request in the last step, and its refusal to the run of its verdict and target."""
        self._verdicts[ruling.verdict] += 1
        if self._busy and not by_name:
            return
        target = None if ruling.target is None else str(ruling.target)
        key = (ruling.verdict, target, by_name)
        run, step = self._running.get(key), ruling.step + 1
        if run is None:
            run = Refusals(ruling.hunter, ruling.verdict, step, step, judged_ms, judged_ms, target, by_name)
            self._running[key] = run
            self.refusals.append(run)
        run.times += 1
        run.last_step, run.last_ms = step, judged_ms
        if (distance := ruling.distance_um) is not None:
            run.nearest_um = distance if run.nearest_um is None else min(run.nearest_um, distance)
            run.farthest_um = distance if run.farthest_um is None else max(run.farthest_um, distance)

    def finished(self, score: int, contests: Sequence[Contest]) -> HunterSummary:
        """Return the summary, with the hunter's score and the results of the match's contests."""
        summary, seat = self._summary, self._summary.seat
        decided = [contest for contest in contests if contest.clause != "R9.1"]  # under R9.1 every claim wins
        lost = [claim for contest in decided for claim in contest.claims[1:] if claim.seat == seat]
        summary.catches, summary.contests_lost = score, len(lost)
        summary.contests_won = sum(contest.claims[0].seat == seat for contest in decided)
        summary.contests_lost_to_mates = sum(claim.mate for claim in lost)
        refused = self._verdicts.keys() - {Verdict.GRANTED, Verdict.LOST_CONTEST}
        summary.refused = dict(sorted((verdict.name, self._verdicts[verdict]) for verdict in refused))
        return summary


class _PreyRecord:
    """Summary and captures of one prey (chapter 12), collected step by step."""

    def __init__(self, index: int, name: str) -> None:
        self.summary = PreySummary(index, name)
        self.captures: list[Capture] = []
        self.targets: dict[str, None] = {}
        """Names of the targets that the prey has played, in their order."""

    def note(self, before: World, after: World) -> None:
        """Add the next step."""
        summary, index = self.summary, self.summary.index
        then, now = before.prey[index], after.prey[index]
        self.targets.update({target: None for target in (then.target, now.target) if target is not None})
        if now.withdrawn and summary.withdrawn_ms is None:
            summary.withdrawn_ms = before.time_ms
        if now.caught_by is not None:
            target = next(state for state in before.targets if state.name == then.target)
            distance = next((ruling.distance_um for ruling in after.rulings if ruling.hunter == now.caught_by), None)
            in_play_ms = before.time_ms - target.spawned_ms
            self.captures.append(
                Capture(index, after.step, before.time_ms, now.caught_by, target.name, distance, in_play_ms)
            )
        summary.times_caught, summary.out = now.times_caught, now.target is None
        if now.target is not None and self.captures and self.captures[-1].returned_ms is None:
            self.captures[-1].returned_ms, self.captures[-1].returned_as = after.time_ms, now.target
