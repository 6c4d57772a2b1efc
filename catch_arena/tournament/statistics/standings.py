"""Standings of the entrants, with the uncertainty of each figure."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from catch_arena.policy import Side
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.statistics.intervals import Estimate, estimates, ratios, shares
from catch_arena.tournament.statistics.outcomes import Outcomes, SideResults, middle_half
from catch_arena.tournament.statistics.ratings import rate
from catch_arena.tournament.statistics.separation import groups
from catch_arena.verdicts import Verdict

_DIGITS = 6
"""Decimals in which ratings must agree to share a place: the last bits depend on the order of the entrants."""


@dataclass(frozen=True, slots=True)
class Standing:
    """Line of one entrant in the table; docs/explanation/ratings.md defines each figure."""

    place: int
    """Place by rating: 1 is best, and equal ratings share a place."""
    name: str
    groups: tuple[int, int]
    """First and last group of the entrant, from 1; entrants in one group have no significant difference."""
    matches: int
    rating: Estimate
    """Rating in points: 0 is the mean; with 400 points more, wins are ten times as likely as defeats."""
    score: Estimate
    """Mean catches per match, of a team in total; for prey, the mean number of times that it was caught."""
    iqm: Estimate
    """Mean score of the middle half of its matches."""
    win_share: Estimate
    """Share of matches won, in [0, 1]; parties that share the first rank share the win."""
    mean_rank: float
    contests_lost: float
    """Mean number of contests per match that a rival won (R5.6)."""
    contest_win_share: float
    """Share of its contests with rivals that it won, in [0, 1]; NaN if there was none."""
    lost_to_mates: float
    """Mean number of requests per match that a team-mate won (R11.3)."""
    refusals: dict[str, float]
    """Mean number of requests per match refused for other reasons, by verdict; verdicts with 0 are left out."""
    forfeits: dict[str, int]
    """Number of forfeited matches, by code."""

    @property
    def group(self) -> str:
        """First and last group of the entrant as text: «1-3» for groups 1 to 3, «1» for one group."""
        return "-".join(str(number) for number in sorted(set(self.groups)))

    @property
    def refused(self) -> float:
        """Mean number of refused requests per match, for all verdicts in `refusals`."""
        return sum(self.refusals.values())


def standings_of_sides(
    entrants: Sequence[Entrant], played: Sequence[PlayedMatch], parties: Parties
) -> dict[Side, list[Standing]]:
    """Return a table for each side, from its own results only (R12.7)."""
    return {side: standings(SideResults.of(entrants, played, parties, side)) for side in parties.sides}


def standings(results: SideResults) -> list[Standing]:
    """Return the table of the entrants that played, highest rating first; the order of play does not change it."""
    entrants, outcomes = results.entrants, results.outcomes
    counts = outcomes.by_block()
    totals = counts.sum(axis=0)
    ratings = rate(outcomes)
    rating = ratings.estimates()
    score = ratios(outcomes.by_block(outcomes.scores), counts)
    win_share = shares(outcomes.by_block(outcomes.win_shares), counts)
    iqm = _interquartile_means(outcomes)
    ranks = outcomes.by_block(outcomes.ranks).sum(axis=0)
    verdicts: list[Counter[str]] = [Counter() for _ in entrants]
    forfeits: list[Counter[str]] = [Counter() for _ in entrants]
    won, lost, to_mates = ([0] * len(entrants) for _ in range(3))
    of_side = range(len(results.played[0].match.seating))[results.parties]
    for one in results.played:
        for party in of_side:
            index = one.match.seating[party]
            verdicts[index].update(one.result.verdicts[party])
            if forfeit := one.result.forfeits[party]:
                forfeits[index][forfeit.code] += 1
            won[index] += one.result.contests_won[party]
            lost[index] += one.result.contests_lost[party]
            to_mates[index] += one.result.lost_to_mates[party] if one.result.lost_to_mates else 0
    order = sorted(
        np.flatnonzero(totals).tolist(), key=lambda index: (-round(rating[index].mean, _DIGITS), entrants[index].name)
    )
    return [
        Standing(
            place=1 + sum(round(rating[other].mean - rating[index].mean, _DIGITS) > 0 for other in order),
            name=entrants[index].name,
            groups=belongs,
            matches=int(totals[index]),
            rating=rating[index],
            score=score[index],
            iqm=iqm[index],
            win_share=win_share[index],
            mean_rank=float(ranks[index] / totals[index]),
            contests_lost=lost[index] / float(totals[index]),
            contest_win_share=won[index] / contests if (contests := won[index] + lost[index]) else math.nan,
            lost_to_mates=to_mates[index] / float(totals[index]),
            refusals={
                verdict.name: verdicts[index][verdict.name] / float(totals[index])
                for verdict in Verdict
                if verdict not in (Verdict.GRANTED, Verdict.LOST_CONTEST) and verdicts[index][verdict.name]
            },
            forfeits=dict(sorted(forfeits[index].items())),
        )
        for index, belongs in zip(order, groups(ratings, order), strict=True)
    ]


def _interquartile_means(outcomes: Outcomes) -> list[Estimate]:
    """Return the mean score of the middle half of each entrant's matches.

    For the interval, a score beyond a quartile counts as the quartile (Huber 1981).
    """
    means = np.full(outcomes.entrants, math.nan)
    pulls = np.zeros(outcomes.seating.shape)
    for index in range(outcomes.entrants):
        here = outcomes.seating == index
        middle = middle_half(outcomes.scores[here])
        if len(middle):
            means[index] = middle.mean()
            held = np.clip(outcomes.scores[here], middle[0], middle[-1])
            pulls[here] = (held - held.mean()) * (len(held) / len(middle))
    return estimates(means, outcomes.by_block(pulls), outcomes.by_block())
