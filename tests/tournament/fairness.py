"""Whether the arena is fair: identical agents in all seats, permuted requests and labels, one agent under two names."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import cycle, islice
from random import Random
from typing import Final

import numpy as np
from scipy import special
from tournament.invariance import Step, lots, names_matter, order_matters, with_labels

from catch_arena.config import ArenaConfig
from catch_arena.errors import AgentError, ConfigError
from catch_arena.policy import Side
from catch_arena.tournament.entrants import Entrant, enter
from catch_arena.tournament.execution.runner import run
from catch_arena.tournament.match import Match
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.secret import Secret
from catch_arena.tournament.statistics.intervals import Estimate, shares
from catch_arena.tournament.statistics.outcomes import Floats, Outcomes
from catch_arena.tournament.statistics.ratings import rate
from catch_arena.tournament.statistics.separation import holm, p_values
from catch_arena.tournament.statistics.sides import on_side

LEVEL: Final = 0.01
"""A fair arena fails an audit so often: all its tests together, corrected for their number (Holm 1979)."""
_DRAWS_NOTHING: Final = "nearest"
_OTHERS: Final = (_DRAWS_NOTHING, "contested", "patrol", "first")
"""Whom the twins play with."""
_QUESTIONS: Final[dict[Side, tuple[str, str, str]]] = {
    "hunter": (
        "Does a seat win more often than another?",
        "Does a seat catch more than another?",
        "Does one agent under two names get two ratings?",
    ),
    "prey": (
        "Does one prey win more often than another?",
        "Is one prey caught more often than another?",
        "Does one agent under two names get two ratings as prey?",
    ),
}
"""What is asked of the results of each side."""
_STEPS: Final = 2000
_REPLAYED: Final = 5
_FEWEST_MATCHES: Final = 100
_FEWEST_TWIN_BLOCKS: Final = 8


@dataclass(frozen=True, slots=True)
class Check:
    """One question, whose right answer is no."""

    question: str
    passed: bool
    finding: str
    """In plain words."""
    p: float | None = None
    """How often a fair arena would look at least this unfair, corrected for the number of such questions; None where
    nothing was left to chance.
    """


@dataclass(frozen=True, slots=True)
class Seat:
    """How the identical agents of one seat fared; of a team's seats, or of one prey's."""

    wins: Estimate
    """Its share of wins, ties shared."""
    score: float


@dataclass(frozen=True, slots=True)
class Audit:
    """All questions and answers."""

    agent: str
    matches: int
    """Of identical agents."""
    seats: tuple[Seat, ...]
    twin_matches: int
    twin_difference: Estimate
    """Between the ratings of one agent under two names, in points, as a hunter; its margin is the noise floor."""
    checks: tuple[Check, ...]
    prey_twin_difference: Estimate | None = None
    """The same as prey, which is rated by itself (R12.7)."""

    @property
    def passed(self) -> bool:
        """Whether nothing unfair was found."""
        return all(check.passed for check in self.checks)


def audit(
    config: ArenaConfig,
    agent: str = _DRAWS_NOTHING,
    *,
    matches: int = 2000,
    seed: Secret | int | None = None,
    jobs: int = 1,
) -> Audit:
    """Ask all the questions.

    Args:
        config: the arena's settings.
        agent: as on the command line.
        matches: how many identical agents play, each on targets of its own; the twins play a quarter as many.
        seed: all that is drawn follows from it; a whole number in [0, 2^64) can be guessed, None draws one freshly.
        jobs: how many processes play.

    Raises:
        ConfigError: for fewer than two hunters, and too few matches.
        AgentError: for a spec that names no agent, and an agent that cannot play.
        NoContest: where a match could not be held.
    """
    parties = Parties.of(config)
    if len(parties) < 2:
        raise ConfigError(f"at least 2 agents must play in a match for an audit, got {len(parties)}")
    if matches < _FEWEST_MATCHES:
        raise ConfigError(f"matches must be at least {_FEWEST_MATCHES} for an audit, got {matches}")

    secret = Secret.of(seed)
    alike = enter([agent] * len(parties))
    twins = enter([agent, agent, *islice(cycle(_OTHERS), parties.group - 2)])
    seat_matches = seat_plan(len(parties), matches, secret.part("audit seats"))
    twin_blocks = max(_FEWEST_TWIN_BLOCKS, matches // 4 // parties.block_size)
    prey = parties if config.prey else None
    twin_matches = tuple(round_robin(parties.group, parties.group, twin_blocks, secret.part("audit twins"), prey))

    def played_by(entrants: Sequence[Entrant], plan: Sequence[Match]) -> dict[Side, Outcomes]:
        # one forfeit is too many: who fails once is not waited for again
        played = run(config, entrants, plan, jobs=jobs, max_forfeits=1)
        for forfeit in (forfeit for one in played for forfeit in one.result.details if forfeit is not None):
            raise AgentError(f"{agent}: must be able to play, for an audit: {forfeit}")
        return {side: Outcomes.of(len(entrants), on_side(played, parties, side)) for side in parties.sides}

    identical, paired = played_by(alike, seat_matches), played_by(twins, twin_matches)
    exact, drawn = permuted_steps(config, secret.seed("audit steps"))
    twin_checks = {side: twins_differ(found, len(twin_matches), side) for side, found in paired.items()}
    seat_checks = [
        check
        for side, found in identical.items()
        if len(parties.seats[parties.on(side)]) > 1  # else there is none to differ from
        for check in seats_differ(found, parties.names[parties.on(side)], side)
    ]
    return Audit(
        agent=alike[0].name,
        matches=len(seat_matches),
        seats=tuple(seat for found in identical.values() for seat in seats_of(found)),
        twin_matches=len(twin_matches),
        twin_difference=twin_checks["hunter"][0],
        prey_twin_difference=twin_checks["prey"][0] if "prey" in twin_checks else None,
        checks=(
            *corrected([*seat_checks, *(check for _, check in twin_checks.values()), *drawn]),
            *exact,
            _exact(
                "Does the order of a step's actions matter?",
                sum(order_matters(config, secret.seed("audit order", number)) for number in range(_REPLAYED)),
                f"{_REPLAYED} matches, handed over in other orders",
            ),
            _exact(
                "Do agents' names and places matter?",
                sum(
                    names_matter(config, secret.seed("audit names", number), enter([_DRAWS_NOTHING])[0])
                    for number in range(_REPLAYED)
                ),
                f"{_REPLAYED} matches, whose names went round",
            ),
        ),
    )


def seat_plan(seats: int, matches: int, seed: Secret | int) -> tuple[Match, ...]:
    """Matches with a seed each: to turn identical agents round would repeat a match, not add one."""
    plan = tuple(round_robin(seats, seats, matches, seed))[::seats]
    return tuple(replace(match, seating=tuple(range(seats))) for match in plan)


def seats_of(identical: Outcomes) -> tuple[Seat, ...]:
    """How each seat fared."""
    wins = shares(identical.win_shares, np.ones_like(identical.win_shares))
    scores = identical.scores.mean(axis=0).tolist()
    return tuple(Seat(share, score) for share, score in zip(wins, scores, strict=True))


def seats_differ(identical: Outcomes, names: Sequence[str], side: Side = "hunter") -> list[Check]:
    """Whether a seat wins, or catches, more than its part; or a team's seats, or one prey.

    Args:
        identical: of one side.
        names: what its parties are called (`Parties.names`).
        side: which one.
    """
    wins, scores = identical.win_shares, identical.scores
    won, scored = 100.0 * wins.mean(axis=0), scores.mean(axis=0)
    asked_wins, asked_scores, _ = _QUESTIONS[side]
    places = [f"seat {name}" for name in names] if side == "hunter" else names
    whose = "seats" if side == "hunter" else "prey"
    return [
        _by_chance(
            asked_wins,
            p_of_no_bias(wins - wins.mean(axis=1, keepdims=True)),
            f"the {whose} won from {won.min():.1f} to {won.max():.1f} % of the matches (most: {places[won.argmax()]})",
        ),
        _by_chance(
            asked_scores,
            p_of_no_bias(scores - scores.mean(axis=1, keepdims=True)),
            f"from {scored.min():.2f} to {scored.max():.2f} catches a match (most: {places[scored.argmax()]})",
        ),
    ]


def twins_differ(paired: Outcomes, matches: int, side: Side) -> tuple[Estimate, Check]:
    """Whether the first two entrants, which are one agent, differ; and by how much, after so many matches."""
    ratings = rate(paired)
    difference = ratings.difference(0, 1)
    return difference, _by_chance(
        _QUESTIONS[side][2],
        float(p_values(ratings)[0, 1]),
        f"{abs(difference.mean):.0f} points apart after {matches} matches, "
        f"where up to {difference.margin:.0f} are noise",
    )


def permuted_steps(config: ArenaConfig, seed: int) -> tuple[list[Check], list[Check]]:
    """What the arbiter says if requests come in another order, and if hunters change their labels; and whether its lots
    are fair to all seats.

    Returns:
        the checks that are exact, and those that chance has a part in.
    """
    random = Random(seed)
    reordered = relabelled = 0
    drawn: list[list[float]] = []
    for _ in range(_STEPS):
        step = Step.drawn(config, random)
        rulings = step.judged()
        reordered += step.in_another_order(random).judged() != rulings
        labels = random.sample(range(config.hunters), config.hunters)
        by_lot = lots(rulings, config)
        expected, judged = with_labels(rulings, labels), step.relabelled(labels).judged()
        relabelled += any(judged[key] != one and one.target not in by_lot for key, one in expected.items())
        for tied, winner in by_lot.values():
            drawn.append([(seat in tied) * ((seat == winner) - 1.0 / len(tied)) for seat in range(config.hunters)])
    exact = [
        _exact("Does the order of requests matter?", reordered, f"{_STEPS} steps, permuted"),
        _exact("Do hunters' labels matter, but for lots?", relabelled, f"{_STEPS} steps, permuted"),
    ]
    question = "Do lots favour a seat?"
    return exact, [_by_chance(question, p_of_no_bias(np.array(drawn)), f"{len(drawn)} lots drawn")] if drawn else []


def p_of_no_bias(rows: Floats) -> float:
    """How often rows like these, if they were 0 in the mean, would have a mean at least so far from it.

    Args:
        rows: (N, seats), independent of each other (the score test: chi-squared over the mean, in the metric of the
            second moments).
    """
    count = len(rows)
    moments = rows.T @ rows / count
    mean = rows.mean(axis=0)
    rank = int(np.linalg.matrix_rank(moments, hermitian=True))
    distance = count * float(mean @ np.linalg.pinv(moments, hermitian=True) @ mean)
    return float(special.chdtrc(rank, distance)) if rank else 1.0


def corrected(checks: Sequence[Check]) -> list[Check]:
    """The same checks, with p-values that allow for their number."""
    p = holm(np.array([check.p for check in checks], dtype=np.float64))
    return [_by_chance(check.question, float(one), check.finding) for check, one in zip(checks, p, strict=True)]


def _by_chance(question: str, p: float, finding: str) -> Check:
    return Check(question, p >= LEVEL, finding, p)


def _exact(question: str, different: int, tried: str) -> Check:
    return Check(question, different == 0, f"{different} differences in {tried}")
