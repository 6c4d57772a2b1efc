"""Ranks at the end of a match (R6.1, R11.1, R12.5)."""

import math
from collections.abc import Sequence


def ranks_of_sides(scores: Sequence[int], lasted: Sequence[int | None], hunting: int) -> tuple[int, ...]:
    """Return the ranks by party, separately for each side: of `hunting` teams by R11.1, then of prey.

    R12.5: The prey that was caught least comes first; withdrawn prey comes after all other.

    Args:
        scores: catches of each team, then the number of times that each prey was caught.
        lasted: the step of each forfeit, as in `ranks_of`.
        hunting: number of hunting parties.
    """
    prey = [(end is not None, caught) for caught, end in zip(scores[hunting:], lasted[hunting:], strict=True)]
    ranks = ranks_of(scores[:hunting], lasted[:hunting])
    return *ranks, *(1 + sum(other < one for other in prey) for one in prey)


def ranks_of(scores: Sequence[int], lasted: Sequence[int | None] | None = None) -> tuple[int, ...]:
    """R6.1, R11.1: Return the ranks: 1 + the number of hunters or teams that did better.

    Args:
        scores: catches of each hunter or team.
        lasted: the step at which each forfeited; None for no forfeit, which is better than any forfeit.
    """
    merits = [
        (math.inf, score) if end is None else (end, 0)
        for score, end in zip(scores, lasted or [None] * len(scores), strict=True)
    ]
    return tuple(1 + sum(other > merit for other in merits) for merit in merits)
