"""Ratings of the entrants, by one fit to all matches, which does not depend on their order.

The model is Davidson's (1970). If entrants of strengths a and b meet, the first ranks above the second with probability
a / (a + b + v sqrt(a b)), and they tie with probability v sqrt(a b) / (a + b + v sqrt(a b)). A match of more than two
counts as all its pairs (a composite likelihood: Varin, Reid and Firth 2011). Pairs are not independent, so errors are
computed from whole blocks. docs/explanation/ratings.md has the rest.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from catch_arena.tournament.statistics.intervals import FEWEST_BLOCKS, Estimate, estimates
from catch_arena.tournament.statistics.outcomes import Floats, Outcomes, Pairs, sums_by

ELO: Final = 400.0 / math.log(10.0)
"""Points per unit of log strength: with 400 points more, wins are ten times as likely as defeats."""
_LONGEST_STEP: Final = 2.0
_TOLERANCE: Final = 1e-10
_MOST_STEPS: Final = 200


@dataclass(frozen=True, slots=True)
class Ratings:
    """Result of the fit."""

    points: Floats
    """Rating of each entrant in points, (entrants,): 0 is the mean of all that played; NaN for no match."""
    influence: Floats
    """Change of each rating that each block causes, in points: (blocks, entrants)."""
    pseudo_influence: Floats
    """Change of each rating that each added game causes, in points, (2 entrants, entrants): see `rate`."""
    blocks: Floats
    """Number of blocks that each entrant played in: (entrants,)."""
    blocks_above: Floats
    """Number of blocks in which the first ranked above the second more often than below: (entrants, entrants)."""

    def estimates(self) -> list[Estimate]:
        """Return each rating with its interval."""
        return estimates(
            self.points,
            self.influence * len(self.influence),
            np.where(self.blocks >= FEWEST_BLOCKS, np.ones_like(self.influence), 0.0),
            (self.pseudo_influence**2).sum(axis=0),
        )

    def distances(self) -> Floats:
        """Return the difference of each pair divided by its standard error, 0 or more: (entrants, entrants).

        It is NaN if one of the pair did not play. The difference is between expected shares against the field, and not
        between ratings: for an entrant that never wins, a rating goes to infinity, and its error grows even faster
        (Hauck and Donner 1977).
        """
        played = np.isfinite(self.points)
        field = int(played.sum())
        with np.errstate(invalid="ignore"):
            beats = _logistic(np.subtract.outer(self.points, self.points) / ELO)
        slopes = np.where(played & played[:, None], beats * (1.0 - beats), 0.0) / field
        to_shares = (np.diag(slopes.sum(axis=1)) - slopes) / ELO
        shares = np.where(played, beats, 0.0).sum(axis=1) / field
        moves, imagined = self.influence @ to_shares.T, self.pseudo_influence @ to_shares.T
        count = max(len(moves), 2)
        covariance = moves.T @ moves * (count / (count - 1)) + imagined.T @ imagined
        own = np.diag(covariance)
        errors = np.sqrt(np.maximum(own[:, None] + own[None, :] - 2.0 * covariance, 0.0))
        with np.errstate(invalid="ignore", divide="ignore"):
            distances: Floats = np.abs(np.subtract.outer(shares, shares)) / errors
        return distances


def rate(outcomes: Outcomes) -> Ratings:
    """Return the ratings that fit the outcomes best.

    Games are added to the played ones: each entrant wins half a game and loses half a game against an opponent of
    rating 0, and two equal opponents play one game and tie half of it. Without them an entrant that never lost would
    have no finite rating.
    """
    pairs = Pairs.of(outcomes)
    blocks_played = (outcomes.by_block() > 0).sum(axis=0)
    strengths, log_tie, information = fit(pairs.table(1), pairs.table(0))
    size = outcomes.entrants

    pulls, tied = _pulls(pairs, strengths, log_tie)
    gradients = np.column_stack((pulls, np.bincount(pairs.block, (pairs.result == 0) - tied, outcomes.blocks)))
    win = _logistic(strengths)
    # for the errors, added games are whole games: see docs/explanation/ratings.md
    imagined = np.pad(np.concatenate((np.diag(1.0 - win), np.diag(-win))), ((0, 0), (0, 1)))

    played = blocks_played > 0
    moves: Floats = ELO * np.linalg.solve(information, np.concatenate((gradients, imagined)).T)[:size].T
    moves -= moves[:, played].mean(axis=1, keepdims=True)
    moves[:, ~played] = 0.0
    influence = moves[: outcomes.blocks]
    return Ratings(
        points=np.where(played, ELO * (strengths - strengths[played].mean()), math.nan),
        influence=influence - influence.mean(axis=0),
        pseudo_influence=moves[outcomes.blocks :],
        blocks=blocks_played.astype(np.float64),
        blocks_above=pairs.blocks_above(),
    )


def local_estimates(outcomes: Outcomes, entrants: Sequence[int]) -> list[Estimate]:
    """Return the ratings of some entrants, with intervals that take the ratings of their opponents as known.

    In a league entrants meet others with near ratings. The distance between two far groups is then uncertain, and would
    widen the intervals of all, though the order within each group is clear.
    """
    pairs, some = Pairs.of(outcomes), [*entrants]
    strengths, log_tie, information = fit(pairs.table(1), pairs.table(0))
    own = np.diag(information)[some] / ELO
    win = _logistic(strengths[some])
    pulls = _pulls(pairs, strengths, log_tie)[0][:, some] / own
    enough = (outcomes.by_block()[:, some] > 0).sum(axis=0) >= FEWEST_BLOCKS
    return estimates(
        ELO * (strengths[some] - strengths.mean()),
        pulls * outcomes.blocks,
        np.where(enough, np.ones_like(pulls), 0.0),
        ((1.0 - win) ** 2 + win**2) / own**2,
    )


def fit(wins: Floats, ties: Floats) -> tuple[Floats, float, Floats]:
    """Maximise the concave log-likelihood by Newton's method, for the tables of `Pairs`.

    Return the log strengths, log v, and the information matrix, in which v is last.
    """
    size = len(wins)
    met = wins + wins.T + ties
    achieved = wins.sum(axis=1) + ties.sum(axis=1) / 2.0
    tied_in_all = ties.sum() / 2.0
    found = np.zeros(size + 1)
    information = np.eye(size + 1)
    for _ in range(_MOST_STEPS):
        strengths, log_tie = found[:size], float(found[size])
        above, below, tied = _chances(strengths[:, None] - strengths[None, :], log_tie)
        win, equals_tie = _logistic(strengths), float(_chances(np.zeros(1), log_tie)[2][0])
        gradient = np.empty(size + 1)
        gradient[:size] = achieved - (met * (above + tied / 2.0)).sum(axis=1) + 0.5 - win
        gradient[size] = tied_in_all - (met * tied).sum() / 2.0 + 0.5 - equals_tie
        curvature = met * ((above + below) / 4.0 - ((above - below) / 2.0) ** 2)
        information[:size, :size] = np.diag(curvature.sum(axis=1) + win * (1.0 - win)) - curvature
        information[:size, size] = information[size, :size] = -(met * (above - below) / 2.0 * tied).sum(axis=1)
        information[size, size] = (met * tied * (1.0 - tied)).sum() / 2.0 + equals_tie * (1.0 - equals_tie)
        step = np.linalg.solve(information, gradient)
        longest = float(np.abs(step).max())
        if longest < _TOLERANCE:
            break
        found = found + step * min(1.0, _LONGEST_STEP / longest)
    return found[:size], float(found[size]), information


def _pulls(pairs: Pairs, strengths: Floats, log_tie: float) -> tuple[Floats, Floats]:
    """Return the pull of each block on each strength, (blocks, entrants), and the probability of a tie of each pair."""
    above, below, tied = _chances(strengths[pairs.first] - strengths[pairs.second], log_tie)
    pull = (pairs.result - (above - below)) / 2.0
    rows = pairs.blocks, pairs.entrants, pairs.block
    return sums_by(*rows, pairs.first, pull) - sums_by(*rows, pairs.second, pull), tied


def _chances(difference: Floats, log_tie: float) -> tuple[Floats, Floats, Floats]:
    """Return Davidson's probabilities (above, below, tied) for a difference of log strengths."""
    above, below = np.exp(difference / 2.0), np.exp(-difference / 2.0)
    total = above + below + math.exp(log_tie)
    return above / total, below / total, math.exp(log_tie) / total


def _logistic(strengths: Floats) -> Floats:
    return 1.0 / (1.0 + np.exp(-strengths))
