"""Who is ahead of whom when a match has ended (R6.1, R11.1, R12.5)."""

import math
from collections.abc import Sequence


def ranks_of_sides(scores: Sequence[int], lasted: Sequence[int | None], hunting: int) -> tuple[int, ...]:
    """The ranks by party, on each side by itself: of `hunting` teams by R11.1, then of prey.

    R12.5: prey that was caught least comes first, and withdrawn prey behind all other.

    Args:
        scores: a team's catches, and how often prey was caught.
        lasted: as of `ranks_of`.
        hunting: how many of them hunt.
    """
    prey = [(end is not None, caught) for caught, end in zip(scores[hunting:], lasted[hunting:], strict=True)]
    ranks = ranks_of(scores[:hunting], lasted[:hunting])
    return *ranks, *(1 + sum(other < one for other in prey) for one in prey)


def ranks_of(scores: Sequence[int], lasted: Sequence[int | None] | None = None) -> tuple[int, ...]:
    """R6.1, R11.1: each one's rank is 1 + how many did better.

    Args:
        scores: catches of each, a hunter or a team.
        lasted: the step at which one forfeited, None for those that did not: they did better than all who did.
    """
    merits = [
        (math.inf, score) if end is None else (end, 0)
        for score, end in zip(scores, lasted or [None] * len(scores), strict=True)
    ]
    return tuple(1 + sum(other > merit for other in merits) for merit in merits)
