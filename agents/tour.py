"""Plans the best order in which to catch a few near targets before its rivals do.

Source: B. L. Golden, L. Levy, R. Vohra, "The orienteering problem", Naval Research Logistics 34 (1987). The few targets
are ordered by branch and bound.
"""

import math
from typing import Final

from catch_arena.agents.contested_by_time import rival_arrival_s
from catch_arena.agents.intercept import meeting_point
from catch_arena.agents.patrol import Point
from catch_arena.agents.triage import race_or_rest, worth_chasing
from catch_arena.policy import Limits, View
from catch_arena.steering import drive, travel_s

MOST_STOPS: Final = 5
"""Most targets in a tour: the nearest that it can reach in time."""
MOST_TARGETS: Final = 10
MOST_RIVALS: Final = 6
"""Number of nearest moving rivals whose catches are predicted."""
PATIENCE_S: Final = 4.0
"""Time after which a catch is worth 1/e of an immediate one [s], since the arena changes meanwhile."""


class Agent:
    """Agent that plans a tour in each step, and drives to its first stop."""

    control = "velocity"

    def reset(self, seed: int) -> None:
        """Do nothing: the agent keeps no state."""

    def act(self, view: View) -> tuple[float, float]:
        """Return speed and turn rate as fractions of the limits, in [-1, 1]."""
        ranks = worth_chasing(view)[:MOST_TARGETS]
        places = [meeting_point(view.targets[rank - 1], view) for rank in ranks]
        tour = best_tour(list(zip(places, taken_s(places, view), strict=True)), view.limits)
        return drive(*tour[0], view.limits) if tour else race_or_rest(ranks, view)


def taken_s(places: list[Point], view: View) -> list[float]:
    """Return the time at which rivals will have taken each target [s], if this hunter takes none.

    The rival and the target that meet soonest are paired first; then that rival continues from there.
    """
    limits = view.limits
    until_s = [math.inf] * len(places)
    racing = [rival for rival in view.rivals if rival.linear_velocity][:MOST_RIVALS]  # others race for nothing
    meetings = {
        (racer, stop): rival_arrival_s(rival, *place, limits)
        for racer, rival in enumerate(racing)
        for stop, place in enumerate(places)
    }
    while meetings:
        (racer, taken), now_s = min(meetings.items(), key=lambda meeting: meeting[1])
        until_s[taken] = now_s
        meetings = {pair: time_s for pair, time_s in meetings.items() if pair[1] != taken}
        ahead, aside = places[taken]
        heading = math.atan2(aside - racing[racer].left, ahead - racing[racer].forward)
        for stop in {stop for _, stop in meetings}:
            meetings[racer, stop] = now_s + leg_s(ahead, aside, heading, places[stop], limits)
        racing[racer] = racing[racer]._replace(forward=ahead, left=aside)
    return until_s


def best_tour(stops: list[tuple[Point, float]], limits: Limits) -> list[Point]:
    """Return the places of the tour of the greatest worth; stops that cannot be reached in time are left out.

    Args:
        stops: each target's place, and the time until which it is there [s].
        limits: the hunter's limits.
    """
    reachable = [stop for stop in stops if leg_s(0.0, 0.0, 0.0, stop[0], limits) <= stop[1]][:MOST_STOPS]
    best: list[Point] = []
    best_worth = 0.0

    def extend(tour: list[Point], left: list[tuple[Point, float]], now_s: float, heading: float, worth: float) -> None:
        """Try each order of the stops that are left, after a given tour."""
        nonlocal best, best_worth
        if worth > best_worth:
            best, best_worth = tour, worth
        ahead, aside = tour[-1] if tour else (0.0, 0.0)
        legs = [(now_s + leg_s(ahead, aside, heading, place, limits), place, until_s) for place, until_s in left]
        legs = sorted(leg for leg in legs if leg[0] <= leg[2])
        if not legs or worth + len(left) * math.exp(-legs[0][0] / PATIENCE_S) <= best_worth:
            return  # not better, even if all were caught together with the first
        for then_s, place, _ in legs:
            rest = [stop for stop in left if stop[0] != place]
            bearing = math.atan2(place[1] - aside, place[0] - ahead)
            extend([*tour, place], rest, then_s, bearing, worth + math.exp(-then_s / PATIENCE_S))

    extend([], reachable, 0.0, 0.0, 0.0)
    return best


def leg_s(ahead: float, aside: float, heading: float, place: Point, limits: Limits) -> float:
    """Return the time from a place and a heading to another place [s], counted as by `arrival_s`."""
    dx, dy = place[0] - ahead, place[1] - aside
    way = max(0.0, math.hypot(dx, dy) - limits.reach_m)
    return travel_s(way, math.remainder(math.atan2(dy, dx) - heading, math.tau), limits)
