"""Ratings of a league from its newest matches, and the opponents whose matches say most about an entrant's place."""

from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Final

import numpy as np

from catch_arena.tournament.match import PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.statistics.intervals import Estimate
from catch_arena.tournament.statistics.outcomes import Outcomes, on_side
from catch_arena.tournament.statistics.ratings import ELO, local_estimates

NEAREST: Final = 32
"""Number of entrants with the nearest ratings among which opponents are chosen."""
_WAITS_TOO: Final = 2.0
"""Factor for an opponent that has no clear place either: the match says something about both."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """Results of some matches about the entrants that played them."""

    ratings: Mapping[int, Estimate] = field(default_factory=dict)
    """Rating of each entrant [points], by its index in the store; the interval takes its opponents' as known."""
    blocks: Mapping[int, int] = field(default_factory=dict)
    """Number of blocks that each entrant played in."""
    met: Mapping[tuple[int, int], int] = field(default_factory=dict)
    """Number of blocks in which two entrants met, the smaller index first."""


def weigh(played: Sequence[PlayedMatch], parties: Parties, zero: int, present: Collection[int]) -> Evidence:
    """Return the evidence of some matches about the present entrants; old versions are rated too, but not returned.

    Args:
        played: the matches, in whole blocks. In an arena with prey, the results of the hunters count.
        parties: the parties of the arena.
        zero: index of the entrant whose rating is 0, if it played.
        present: indices of the entrants that still play.
    """
    if not played:
        return Evidence()
    matches = on_side(played, parties)
    players, places = np.unique([one.seating for one in matches], return_inverse=True)
    outcomes = replace(Outcomes.of(len(players), matches), seating=places.reshape(len(matches), -1))
    here = np.flatnonzero(np.isin(players, [*present])).tolist()
    names = players[here].tolist()
    ratings = dict(zip(names, local_estimates(outcomes, here), strict=True))
    blocks = (outcomes.by_block() > 0).sum(axis=0)[here].tolist()
    shift = ratings[zero].mean if zero in ratings else 0.0
    groups: defaultdict[int, set[int]] = defaultdict(set)
    for one in played:
        groups[one.match.block].update(one.match.seating)
    return Evidence(
        {name: Estimate(one.mean - shift, one.low - shift, one.high - shift) for name, one in ratings.items()},
        dict(zip(names, blocks, strict=True)),
        Counter(pair for group in groups.values() for pair in combinations(sorted(group), 2)),
    )


def next_blocks(
    waiting: Sequence[int],
    pool: Collection[int],
    evidence: Evidence,
    group: int,
    draw: Callable[[int, int], int],
) -> list[tuple[int, ...]]:
    """Return the players of the next blocks, such that each waiting entrant is in one of them.

    The opponents of an entrant are those that say most about its place: a match between equals says most, and a further
    match against the same opponent says less. The first match of an entrant is against the middle of the pool.

    Args:
        waiting: entrants without a clear place; the first ones choose first.
        pool: all entrants that can play, the waiting ones included.
        evidence: what the matches so far say.
        group: number of players in a block.
        draw: returns a number for an entrant and a possible opponent, which decides between equally good ones.
    """
    middle = float(np.median([evidence.ratings[one].mean for one in pool if one in evidence.ratings] or [0.0]))
    points = {one: evidence.ratings[one].mean if one in evidence.ratings else middle for one in pool}
    ladder = sorted(pool, key=lambda one: (points[one], one))
    heights = [points[one] for one in ladder]
    left = dict.fromkeys(waiting)
    blocks = []
    while left:
        player = next(iter(left))
        del left[player]
        place = bisect_left(heights, points[player])
        near = ladder[max(0, place - NEAREST) : place + NEAREST]

        def worth(other: int, player: int = player) -> float:
            win = 1.0 / (1.0 + np.exp((points[player] - points[other]) / ELO))
            met = evidence.met.get((min(player, other), max(player, other)), 0)
            return float(win * (1.0 - win) / (1 + met) * (_WAITS_TOO if other in left else 1.0))

        near.sort(key=lambda other: (-worth(other), draw(player, other)))
        others = [other for other in near if other != player][: group - 1]
        for other in others:
            left.pop(other, None)
        blocks.append((player, *others))
    return blocks
