"""Plans a tour over the nearest few targets: the order that catches most of them soonest, before rivals take them.

The orienteering problem: B. L. Golden, L. Levy, R. Vohra, "The orienteering problem", Naval Research Logistics 34
(1987). So few targets are solved by branch and bound.
"""

import math
from typing import Final

from catch_arena.agents.contested_by_time import rival_arrival_s
from catch_arena.agents.intercept import meeting_point
from catch_arena.agents.patrol import Point, drive
from catch_arena.agents.triage import race_or_rest, worth_chasing
from catch_arena.policy import Limits, View

MOST_STOPS: Final = 5
"""So many of the nearest targets that can be had are put in order."""
MOST_TARGETS: Final = 10
MOST_RIVALS: Final = 6
"""The nearest that count in what rivals will have taken."""
PATIENCE_S: Final = 4.0
"""A catch is worth 1 at once, and 1/e of it after this time: by then the arena looks otherwise."""


class Agent:
    """It plans anew in each step, and drives to the first stop."""

    control = "velocity"

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: View) -> tuple[float, float]:
        """Speed and turn rate as parts of the limits, in [-1, 1]."""
        ranks = worth_chasing(view)[:MOST_TARGETS]
        places = [meeting_point(view.targets[rank - 1], view) for rank in ranks]
        tour = best_tour(list(zip(places, taken_s(places, view), strict=True)), view.limits)
        return drive(*tour[0], view) if tour else race_or_rest(ranks, view)


def taken_s(places: list[Point], view: View) -> list[float]:
    """When rivals will have taken each target [s], if this hunter takes none: always the rival and the target that meet
    soonest, and then that rival goes on from there.
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
    """The stops, each with the time until which it is there [s], in the order of the greatest worth; those that cannot
    be had are left out.
    """
    reachable = [stop for stop in stops if leg_s(0.0, 0.0, 0.0, stop[0], limits) <= stop[1]][:MOST_STOPS]
    best: list[Point] = []
    most = 0.0

    def extend(tour: list[Point], left: list[tuple[Point, float]], now_s: float, heading: float, worth: float) -> None:
        """Try each order of what is left behind a tour."""
        nonlocal best, most
        if worth > most:
            best, most = tour, worth
        ahead, aside = tour[-1] if tour else (0.0, 0.0)
        legs = [(now_s + leg_s(ahead, aside, heading, place, limits), place, until_s) for place, until_s in left]
        legs = sorted(leg for leg in legs if leg[0] <= leg[2])
        if not legs or worth + len(left) * math.exp(-legs[0][0] / PATIENCE_S) <= most:
            return  # even if all were caught together with the first
        for then_s, place, _ in legs:
            others = [stop for stop in left if stop[0] != place]
            bearing = math.atan2(place[1] - aside, place[0] - ahead)
            extend([*tour, place], others, then_s, bearing, worth + math.exp(-then_s / PATIENCE_S))

    extend([], reachable, 0.0, 0.0, 0.0)
    return best


def leg_s(ahead: float, aside: float, heading: float, place: Point, limits: Limits) -> float:
    """How long it takes from a place, with a heading, to another [s]; as `arrival_s` counts."""
    dx, dy = place[0] - ahead, place[1] - aside
    turn = abs(math.remainder(math.atan2(dy, dx) - heading, math.tau))
    way = max(0.0, math.hypot(dx, dy) - limits.reach_m)
    return way / limits.max_speed_mps + 0.5 * turn / limits.max_turn_rate_radps
