"""Assigns targets to all hunters in view so that all together do best, and chases its own.

H. W. Kuhn, "The Hungarian method for the assignment problem", Naval Research Logistics Quarterly 2 (1955); J. Munkres,
"Algorithms for the assignment and transportation problems", SIAM Journal 5 (1957).
"""

import math
from collections.abc import Sequence
from typing import Final

from catch_arena.agents.contested_by_time import arrival_s, rival_arrival_s
from catch_arena.agents.intercept import meeting_point
from catch_arena.agents.patrol import rest
from catch_arena.agents.triage import LOST_BY_S, race_or_rest, worth_chasing
from catch_arena.policy import View
from catch_arena.steering import drive

MOST_TARGETS: Final = 16
MOST_RIVALS: Final = 8
"""Number of nearest rivals that count; the work grows with targets times the square of hunters."""
PATIENCE_S: Final = 1.0
"""Time after which a catch is worth 1/e of an immediate one [s]; it keeps near targets with the hunter next to them."""


class Agent:
    """Agent that solves an assignment problem. Rivals need not follow it, but they too prefer near targets."""

    control = "velocity"

    def reset(self, seed: int) -> None:
        """Do nothing: the agent keeps no state."""

    def act(self, view: View) -> tuple[float, float]:
        """Return speed and turn rate as fractions of the limits, in [-1, 1]."""
        ranks = worth_chasing(view)[:MOST_TARGETS]
        if not ranks:
            return rest(view)
        places = [meeting_point(view.targets[rank - 1], view) for rank in ranks]
        racing = [rival for rival in view.rivals if rival.linear_velocity][:MOST_RIVALS]
        times_s = [[arrival_s(*place, view.limits) for place in places]]
        times_s += [[rival_arrival_s(rival, *place, view.limits) for place in places] for rival in racing]
        own = cheapest_assignment([[-math.exp(-time_s / PATIENCE_S) for time_s in row] for row in times_s])[0]
        if own is None or times_s[0][own] - min(row[own] for row in times_s) >= LOST_BY_S:
            return race_or_rest(ranks, view)
        return drive(*places[own], view.limits)


def cheapest_assignment(costs: Sequence[Sequence[float]]) -> list[int | None]:
    """Return the column of each row, with each column used at most once and the least sum of costs.

    With more rows than columns some rows get None; with more columns than rows some columns stay unused. Rows are added
    one by one, each by the shortest augmenting path (R. Jonker, A. Volgenant, Computing 38, 1987).
    """
    if costs and len(costs) > len(costs[0]):
        rows: list[int | None] = [None] * len(costs)
        for column, row in enumerate(cheapest_assignment(list(zip(*costs, strict=True)))):
            if row is not None:
                rows[row] = column
        return rows
    columns = range(len(costs[0])) if costs else range(0)
    row_of: list[int | None] = [None for _ in columns]
    row_price, column_price = [0.0] * len(costs), [0.0 for _ in columns]
    for new in range(len(costs)):
        # to each column: the length of the shortest path in reduced costs, and the column before it on that path
        reached_by = [math.inf for _ in columns]
        before: list[int | None] = [None for _ in columns]
        done: list[int] = []
        row, end, way = new, None, 0.0
        while row is not None:
            for column in columns:
                if column in done:
                    continue
                length = way + costs[row][column] - row_price[row] - column_price[column]
                if length < reached_by[column]:
                    reached_by[column], before[column] = length, end
            end = min((column for column in columns if column not in done), key=reached_by.__getitem__)
            way, row = reached_by[end], row_of[end]
            done.append(end)
        row_price[new] += way
        for column in done[:-1]:
            owner = row_of[column]
            row_price[owner] += way - reached_by[column]
            column_price[column] -= way - reached_by[column]
        while end is not None:
            step_back = before[end]
            row_of[end] = new if step_back is None else row_of[step_back]
            end = step_back
    assigned: list[int | None] = [None] * len(costs)
    for column, row in enumerate(row_of):
        if row is not None:
            assigned[row] = column
    return assigned
