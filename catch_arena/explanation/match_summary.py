"""What happened in a match, from the arbiter's evidence (R5.6): contests, refusals, and what became of each hunter."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Final

import numpy as np

from catch_arena.core.jit import entry
from catch_arena.core.random import service_lot, tie_lot
from catch_arena.explanation.seats import find_seat, how_it_left, labels
from catch_arena.explanation.sight import Sight
from catch_arena.replay import Replay
from catch_arena.verdicts import Ruling, Verdict
from catch_arena.world import World

_CONTESTED: Final = (Verdict.GRANTED, Verdict.KILL_FAILED, Verdict.LOST_CONTEST)


@dataclass(frozen=True, slots=True)
class Claim:
    """One hunter's part in a contest."""

    seat: int
    verdict: Verdict
    distance_um: int | None
    """At the step's beginning (R5.3); None under the policy `capstone`, which does not measure."""
    lot: int | None = None
    """Where a lot decided (R5.5, R5.9): its word, of which the lowest wins."""


@dataclass(frozen=True, slots=True)
class Contest:
    """Several hunters could have caught one target in one step."""

    step: int
    """Counted from 1."""
    time_ms: int
    """When the step ended."""
    target: str
    clause: str
    """What decided: R5.4 the distance, R5.5 a lot among equally near ones, R5.9 the queue of `first_come`, R9.1 that
    the capstone's service refuses nobody.
    """
    claims: tuple[Claim, ...]
    """The winner first, then the nearer ones first."""

    @property
    def margin_um(self) -> int | None:
        """How much nearer the winner was than the nearest loser; negative where a lot preferred a farther one."""
        first, second = (claim.distance_um for claim in self.claims[:2])
        return None if first is None or second is None else second - first


@dataclass(slots=True)
class Refusals:
    """One hunter's requests that were refused for the same reason, with no catch and no contest of its own between."""

    seat: int
    verdict: Verdict
    first_step: int
    last_step: int
    first_ms: int
    """When the first of these steps ended."""
    last_ms: int
    times: int = 0
    targets: list[str] = field(default_factory=list)
    """Each target once; none where no rank that was asked for had one."""
    nearest_um: int | None = None
    farthest_um: int | None = None


@dataclass(slots=True)
class HunterSummary:
    """What became of one hunter."""

    seat: int
    name: str
    catches: int = 0
    contests_won: int = 0
    contests_lost: int = 0
    won_by_um: float | None = None
    """How much nearer than the nearest rival it was in the contests that it won, on average."""
    lost_by_um: float | None = None
    """How much nearer the winner was in those that it lost, on average."""
    refused: dict[str, int] = field(default_factory=dict)
    """Requests refused for other reasons, by verdict."""
    forestalled: int = 0
    """Targets that it was heading for, and that another hunter caught without a contest between them."""
    never_seen: int | None = None
    """Targets that another hunter caught, and that it never had in sight (R7.5); None where hunters see everything."""
    withdrawn_ms: int | None = None
    dropped_out: bool = False
    """It left by chance (R1.7), and was not withdrawn (R1.6)."""


@dataclass(frozen=True, slots=True)
class Explanation:
    """The contests and refusals of a match, and a summary of each hunter that was asked about."""

    title: str
    policy: str
    reaches_um: tuple[int, ...]
    """By seat (R2.7)."""
    steps: int
    duration_ms: int
    names: tuple[str, ...]
    """What the hunters are called, by seat."""
    scores: tuple[int, ...]
    contests: tuple[Contest, ...]
    refusals: tuple[Refusals, ...]
    records: tuple[HunterSummary, ...]

    def lines(self) -> list[str]:
        """The match in words: a paragraph for each contest and each run of refusals in their order, then one for each
        hunter.
        """
        from catch_arena.explanation.sentences import paragraphs

        return paragraphs(self)

    def to_dict(self) -> dict[str, Any]:
        """The same for programs: JSON-ready; verdicts by name, lots in hexadecimal digits, distances in micrometres."""
        return {name: json_ready(value) for name, value in asdict(self).items()}


def explain(
    replay: Replay, hunter: int | str | None = None, progress: Callable[[int, int], None] | None = None
) -> Explanation:
    """Play a match again, and tell its contests and refusals.

    Args:
        replay: the recorded match.
        hunter: a seat or an agent's name, to hear of that one alone.
        progress: called with (steps played, steps in all).

    Raises:
        ReplayError: where the match does not play as recorded.
        ConfigError: for an unknown hunter.
    """
    chosen = range(replay.config.hunters) if hunter is None else (find_seat(replay, hunter),)
    names = labels(replay.names)
    contests: list[Contest] = []
    refusals: list[Refusals] = []
    running: dict[tuple[int, Verdict], Refusals] = {}
    refused = [Counter[str]() for _ in names]
    summaries = [HunterSummary(seat, name) for seat, name in enumerate(names)]
    scores: tuple[int, ...] = ()
    sight = _SightOfMatch(replay) if replay.config.partial_view else None
    for step, world in enumerate(replay.worlds()):
        if sight is not None:
            sight.note(world, summaries)
        _note_departures(replay, world, summaries)
        found = contests_of(replay, world)
        contests += found
        _note_refusals(world, {claim.seat for contest in found for claim in contest.claims}, running, refusals)
        _note_forestalled(world, found, summaries)
        for ruling in world.rulings:
            if ruling.verdict not in (Verdict.GRANTED, Verdict.LOST_CONTEST):
                refused[ruling.hunter][ruling.verdict.name] += 1
        scores = tuple(hunter.score for hunter in world.hunters)
        if progress is not None:
            progress(step, replay.steps)
    _count_contests(summaries, contests)
    for summary, score, tally in zip(summaries, scores, refused, strict=True):
        summary.catches, summary.refused = score, dict(sorted(tally.items()))
    return Explanation(
        title=replay.title,
        policy=replay.config.policy,
        reaches_um=replay.config.reaches_um,
        steps=replay.steps,
        duration_ms=replay.steps * replay.config.control_period_ms,
        names=names,
        scores=scores,
        contests=tuple(one for one in contests if any(claim.seat in chosen for claim in one.claims)),
        refusals=tuple(one for one in refusals if one.seat in chosen),
        records=tuple(summaries[seat] for seat in chosen),
    )


def contests_of(replay: Replay, world: World) -> list[Contest]:
    """The contests of the step that led to a world."""
    by_target: dict[object, list[Ruling]] = {}
    for ruling in world.rulings:
        if ruling.verdict in _CONTESTED:
            by_target.setdefault(ruling.target, []).append(ruling)
    return [_contest(replay, world, str(target), asked) for target, asked in by_target.items() if len(asked) > 1]


def _contest(replay: Replay, world: World, target: str, asked: Sequence[Ruling]) -> Contest:
    asked = sorted(asked, key=lambda ruling: (-ruling.verdict, ruling.distance_um or 0, ruling.hunter))
    nearest = asked[0].distance_um
    tied = [ruling.hunter for ruling in asked if ruling.distance_um == nearest]
    lots: dict[int, int] = {}
    seed, step = np.uint64(replay.seed), world.step - 1
    if replay.config.policy == "capstone":
        clause = "R9.1"
    elif replay.config.policy == "first_come":
        clause = "R5.9"
        lots = {ruling.hunter: int(_service_lot(seed, step, ruling.hunter)) for ruling in asked}
    elif len(tied) > 1:
        clause = "R5.5"
        number = int(target.removeprefix(replay.config.name_prefix))
        lots = {seat: int(_tie_lot(seed, step, number, seat)) for seat in tied}
    else:
        clause = "R5.4"
    claims = tuple(
        Claim(ruling.hunter, ruling.verdict, ruling.distance_um, lots.get(ruling.hunter)) for ruling in asked
    )
    return Contest(world.step, world.time_ms, target, clause, claims)


@entry
def _tie_lot(seed: np.uint64, step: int, number: int, seat: int) -> np.uint64:
    """R5.5: the core's own rule, with a door to Python."""
    return tie_lot(seed, step, number, seat)


@entry
def _service_lot(seed: np.uint64, step: int, seat: int) -> np.uint64:
    """R5.9: the core's own rule, with a door to Python."""
    return service_lot(seed, step, seat)


def _note_refusals(
    world: World, contested: set[int], running: dict[tuple[int, Verdict], Refusals], found: list[Refusals]
) -> None:
    """Adds the step's refusals to the runs that they go on, or begins new ones; a contest is told as such."""
    for ruling in world.rulings:
        if ruling.success or ruling.hunter in contested:
            for verdict in Verdict:
                running.pop((ruling.hunter, verdict), None)
            continue
        run = running.get((ruling.hunter, ruling.verdict))
        if run is None:
            run = Refusals(ruling.hunter, ruling.verdict, world.step, world.step, world.time_ms, world.time_ms)
            running[ruling.hunter, ruling.verdict] = run
            found.append(run)
        run.times += 1
        run.last_step, run.last_ms = world.step, world.time_ms
        if ruling.target is not None and ruling.target not in run.targets:
            run.targets.append(str(ruling.target))
        if (distance := ruling.distance_um) is not None:
            run.nearest_um = distance if run.nearest_um is None else min(run.nearest_um, distance)
            run.farthest_um = distance if run.farthest_um is None else max(run.farthest_um, distance)


class _SightOfMatch:
    """R7.5: what each hunter has had in sight so far."""

    def __init__(self, replay: Replay) -> None:
        self._sight = Sight(replay.config)
        self._seen: list[set[str]] = [set() for _ in replay.names]

    def note(self, world: World, summaries: Sequence[HunterSummary]) -> None:
        """One more state, and the catches that led to it."""
        caught = [(str(ruling.target), ruling.hunter) for ruling in world.rulings if ruling.success]
        names = np.array([target.name for target in world.targets], dtype=object)
        for summary, seen in zip(summaries, self._seen, strict=True):
            missed = sum(by != summary.seat and name not in seen for name, by in caught)
            summary.never_seen = (summary.never_seen or 0) + missed
            if not world.hunters[summary.seat].withdrawn:
                seen.update(names[self._sight.of(world, summary.seat)].tolist())


def _note_departures(replay: Replay, world: World, summaries: Sequence[HunterSummary]) -> None:
    """R1.6, R1.7: a hunter that takes no part in a step has left at its beginning."""
    for summary, hunter in zip(summaries, world.hunters, strict=True):
        if hunter.withdrawn and summary.withdrawn_ms is None:
            summary.withdrawn_ms = world.time_ms - replay.config.control_period_ms
            summary.dropped_out = how_it_left(replay, summary.seat) == "dropped out"


def _note_forestalled(world: World, contests: Sequence[Contest], summaries: Sequence[HunterSummary]) -> None:
    """R4.1's active target was caught by somebody else, and the hunter did not even contest it."""
    catchers = {ruling.target: ruling.hunter for ruling in world.rulings if ruling.success}
    contested = {(contest.target, claim.seat) for contest in contests for claim in contest.claims}
    for summary, hunter in zip(summaries, world.hunters, strict=True):
        goal = hunter.active_target
        if catchers.get(goal, summary.seat) != summary.seat and (goal, summary.seat) not in contested:
            summary.forestalled += 1


def _count_contests(summaries: Sequence[HunterSummary], contests: Sequence[Contest]) -> None:
    """Contests won and lost, and by how much on average."""
    won: list[list[int]] = [[] for _ in summaries]
    lost: list[list[int]] = [[] for _ in summaries]
    for contest in contests:
        if contest.clause == "R9.1":
            continue  # everybody won
        winner, *losers = contest.claims
        won[winner.seat].append(contest.margin_um or 0)
        for claim in losers:
            lost[claim.seat].append((claim.distance_um or 0) - (winner.distance_um or 0))
    for summary in summaries:
        wins, losses = won[summary.seat], lost[summary.seat]
        summary.contests_won, summary.contests_lost = len(wins), len(losses)
        summary.won_by_um = sum(wins) / len(wins) if wins else None
        summary.lost_by_um = sum(losses) / len(losses) if losses else None


def json_ready(value: Any) -> Any:
    """Verdicts by name, lots as hexadecimal digits: a program that reads JSON may not know 64-bit integers."""
    if isinstance(value, Verdict):
        return value.name
    if isinstance(value, dict):
        return {
            key: f"{part:016x}" if key == "lot" and part is not None else json_ready(part)
            for key, part in value.items()
        }
    return [json_ready(part) for part in value] if isinstance(value, list | tuple) else value
