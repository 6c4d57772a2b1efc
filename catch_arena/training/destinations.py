"""Candidate destinations of a hunter and their features: the input of the networks that ship.

A *candidate* is a place: a target in view, the middle of the hunter's own ground, or a waiting point. Each is described
by the same features in every scenario, so that one network plays with any number of targets and rivals, in any arena.

In the shapes of arrays there are N hunters, C candidates (P places, then K targets) and R rivals.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.batch_policy import BatchView
from catch_arena.geometry import is_nearer, own_frame, place_after, world_frame
from catch_arena.policy import Limits, View
from catch_arena.steering import LONGEST_LEAD_S, travel_s

VERSION: Final = 1
"""Version of the features: a network that was trained with another version cannot use these."""

NEVER_S: Final = 1e3
"""Arrival time of an absent rival [s]."""
RIVALS: Final = 3
"""Number of rivals that are described for each candidate: those that would arrive first."""
GRID: Final = 3
"""Points per side of the grid of waiting points."""
GROUND: Final = 5
"""Points per side of the grid by which a hunter's own ground is found."""
BEHIND_M: Final = 0.2
"""Typical distance between a hunter and the centre of a target that it has just caught [m]."""
GIVEN_UP_S: Final = 0.4
"""Delay [s] above which a lost race is given up."""
LENGTH_M: Final = 3.0
"""Unit of lengths in the features [m]."""
FARTHEST_S: Final = 3.0
"""Time that stands for an absent rival or next target in the features [s]; arrivals are cut at twice this."""

_OF_CANDIDATE: Final = (
    *("forward", "left", "distance", "bearing_cos", "bearing_sin", "bearing", "arrival", "won"),
    *("next", "next_won", "second_won", "density", "wall_x", "wall_y", "preferred", "is_place", "is_ground"),
    *("age", "active", "moving_ahead", "moving_aside", "from_ground"),
    *("targets", "caught", "speed", "turn_rate", "time_left"),
)
"""Names of the features of a candidate; values lie between about -3 and 3."""
_OF_RIVAL: Final = ("margin", "bound_there", "facing_it", "distance", "speed", "mate")
"""Names of the features of each of the rivals that would be at a candidate first."""
FEATURES: Final = (*_OF_CANDIDATE, *(f"rival_{rival}_{name}" for rival in range(RIVALS) for name in _OF_RIVAL))
"""Names of all F features, in order."""

Floats = NDArray[np.float64]


class Destinations(NamedTuple):
    """The candidates of N hunters: first the places (P), then the targets (K) by rank; C = P + K."""

    forward: NDArray[np.float64]
    """Distance ahead, in the hunter's own frame [m]: (N, C)."""
    left: NDArray[np.float64]
    """Distance to the left, in the hunter's own frame [m]: (N, C)."""
    legal: NDArray[np.bool_]
    """Candidates that may be chosen: (N, C)."""
    features: NDArray[np.float32]
    """Features in the order of FEATURES, 0 for candidates that are not legal: (N, C, F)."""
    preferred: NDArray[np.int64]
    """Candidate that a good scripted agent would choose: (N,)."""
    places: int
    """P, the number of places: a candidate c >= P is the target of rank c - P + 1."""


def destinations(view: View | BatchView) -> Destinations:
    """Return the candidates and features of one hunter (N = 1) or of many.

    Under target control the only place is the hunter's own, because it can only chase or hold. Otherwise the places are
    its own ground and the waiting points, and a target that is as good as caught is not legal.
    """
    if isinstance(view, View):
        view = BatchView(np.array([view.observation]), np.zeros((1, 0), np.int8), view.limits)
    return _Hunters(view).destinations()


class _Hunters:
    """N hunters, the targets (N, K) and rivals (N, R, 1) that they see, and all arrival times at each candidate."""

    def __init__(self, view: BatchView) -> None:
        view = BatchView(np.asarray(view.observations, np.float64), view.masks, view.limits)
        self.limits: Limits = view.limits
        self.hosted = view.limits.control == "target"
        self.own: Any = type(view.own)(*(column[:, None] for column in view.own))
        self.targets = view.targets
        self.rivals: Any = type(view.rivals)(*(column[..., None] for column in view.rivals))
        self.ground = self._own_ground()
        places = [np.zeros_like(self.ground)] if self.hosted else [self.ground, self._in_own_frame(GRID)]
        self.places = sum(points.shape[2] for points in places)
        self.forward, self.left = np.concatenate((*places, self._meetings()), axis=2)
        caught = self._nearly_caught()
        self.alive = (self.targets.present > 0) & ~caught
        self.caught = caught.any(axis=1, keepdims=True)
        self.own_arrival = self._arrival_s(self.forward, self.left)
        dx, dy = self.forward[:, None] - self.rivals.forward, self.left[:, None] - self.rivals.left
        ahead, aside = own_frame(self.rivals.heading_cos, self.rivals.heading_sin, dx, dy)
        self.far = np.sqrt(dx * dx + dy * dy)
        self.facing = ahead / (self.far + 1e-3)
        """Cosine of the angle between a rival's heading and the direction of the candidate: (N, R, C).

        `far`, the distance [m], and `rival_arrivals`, the arrival time [s], have the same shape.
        """
        self.rival_arrivals = np.where(self.rivals.present > 0, self._arrival_s(ahead, aside), NEVER_S)
        self.first_rival_arrival = self.rival_arrivals.min(axis=1, initial=NEVER_S)
        self.best, self.lost_by = self._best_races()

    def _in_own_frame(self, points: int) -> Floats:
        """Return a grid of points x points in the arena, as (forward, left) [m]: (2, N, points * points)."""
        middles, own = (np.arange(points) + 0.5) * self.limits.side_m / points, self.own
        dx, dy = np.repeat(middles, points) - own.x, np.tile(middles, points) - own.y
        return np.stack(own_frame(own.heading_cos, own.heading_sin, dx, dy))

    def _is_nearest(self, forward: Floats, left: Floats) -> NDArray[np.bool_]:
        """Return whether no rival is nearer to these points of the hunter's own frame: (N, points)."""
        nearer = is_nearer(self.rivals, forward[:, None], left[:, None])
        nearest: NDArray[np.bool_] = ~(nearer & (self.rivals.present > 0)).any(axis=1)
        return nearest

    def _own_ground(self) -> Floats:
        """Return the mean of the points of the arena to which no rival is nearer, in the own frame [m]: (2, N, 1)."""
        points = self._in_own_frame(GROUND)
        own = self._is_nearest(*points)
        mean: Floats = (points * own).sum(axis=2, keepdims=True) / np.maximum(1, own.sum(axis=1))[:, None]
        return mean

    def _meetings(self) -> Floats:
        """Return the places at which moving targets can be met, in the own frame [m]: (2, N, K).

        Place and arrival time depend on each other, so they are computed twice in turn.
        """
        place = self.targets.forward, self.targets.left
        for _ in range(2 if self.limits.targets_move else 0):
            place = place_after(self.targets, np.minimum(LONGEST_LEAD_S, self._arrival_s(*place)))
        return np.stack(place)

    def _nearly_caught(self) -> NDArray[np.bool_]:
        """Return whether a target is as good as caught: (N, K).

        Only the nearest target can be, if it is within reach and no rival is nearer to it; none under target control.
        """
        forward, left = self.targets.forward[:, :1], self.targets.left[:, :1]
        caught: NDArray[np.bool_] = self.targets.present > 0
        within = forward * forward + left * left < (0.999 * self.limits.reach_m) ** 2
        alone = self.limits.hunters_per_catch == 1  # else the hunter must wait for a partner
        caught[:, :1] &= within & self._is_nearest(forward, left) & (alone and not self.hosted)
        caught[:, 1:] = False
        return caught

    def _arrival_s(self, forward: Floats, left: Floats) -> Floats:
        """Return the times until points of a frame [m] are within reach [s]."""
        way = np.maximum(0.0, np.sqrt(forward * forward + left * left) - self.limits.reach_m)
        return travel_s(way, np.arctan2(left, forward), self.limits)

    def _best_races(self) -> tuple[NDArray[np.int64], Floats]:
        """Return the best target (from 0) of the hunter and each rival, (N, 1 + R), and the hunter's delay [s], (N,).

        The hunter is before its rivals. -1 means that there is no target, or that a rival is absent or stands still.
        The delay is 0 if the hunter wins a race.
        """
        races = np.concatenate((self.own_arrival[:, None], self.rival_arrivals), axis=1)[..., self.places :]
        moving = (self.rivals.present > 0) & (self.rivals.linear_velocity != 0)
        racing = np.concatenate((np.ones((len(moving), 1, 1), np.bool_), moving), axis=1)
        times = np.where(racing, races, NEVER_S)
        first, second = _two_smallest(times.swapaxes(0, 1), NEVER_S)
        first_others = np.where(times == first[:, None], second[:, None], first[:, None])
        late = np.where(self.alive[:, None], times - first_others, NEVER_S)
        cost = np.where(late <= 0.0, times, NEVER_S + late)
        best = np.where(racing[..., 0] & self.alive.any(axis=1)[:, None], cost.argmin(axis=2), -1)
        return best, np.maximum(0.0, late[:, 0].min(axis=1))

    def destinations(self) -> Destinations:
        """Return the candidates of these hunters with all features."""
        given_up = (self.lost_by > GIVEN_UP_S) & (not self.hosted)
        preferred = np.where((self.best[:, 0] < 0) | given_up, 0, self.places + self.best[:, 0])
        legal = np.concatenate((np.ones((len(self.alive), self.places), np.bool_), self.alive), axis=1)
        features = np.zeros((*legal.shape, len(FEATURES)), np.float32)
        by_name = {**self._candidates(), **self._next_targets()}
        by_name["preferred"] = np.arange(legal.shape[1]) == preferred[:, None]
        for name, values in by_name.items():
            features[..., _OF_CANDIDATE.index(name)] = values
        features[..., len(_OF_CANDIDATE) :] = self._first_rivals()
        features[~legal] = 0.0
        return Destinations(self.forward, self.left, legal, features, preferred, self.places)

    def _candidates(self) -> dict[str, Any]:
        """Return the features of places and kinds of the candidates, and of the hunter itself, by name."""
        x, y, own, middle = self.forward, self.left, self.own, 0.5 * self.limits.side_m
        distance, number = np.sqrt(x * x + y * y), np.arange(x.shape[1])
        dx, dy = world_frame(own.heading_cos, own.heading_sin, x, y)
        from_ground = np.sqrt((self.ground[0] - x) ** 2 + (self.ground[1] - y) ** 2)
        by_name = {
            "forward": x / LENGTH_M,
            "left": y / LENGTH_M,
            "distance": distance / LENGTH_M,
            "bearing_cos": x / (distance + 1e-3),
            "bearing_sin": y / (distance + 1e-3),
            "bearing": np.abs(np.arctan2(y, x)) / np.pi,
            "arrival": np.minimum(self.own_arrival, 2.0 * FARTHEST_S),
            "won": self.own_arrival < self.first_rival_arrival,
            "wall_x": np.abs(own.x + dx - middle) / middle,
            "wall_y": np.abs(own.y + dy - middle) / middle,
            "is_place": number < self.places,
            "is_ground": (number == 0) & (not self.hosted),
            "from_ground": np.minimum(2.0, from_ground / LENGTH_M),
            "targets": self.alive.sum(axis=1, keepdims=True) / 8.0,
            "caught": self.caught,
            "speed": own.linear_velocity / 2.0,
            "turn_rate": own.angular_velocity / 4.0,
            "time_left": np.minimum(1.0, own.time_left / 60.0),
        }
        targets = {"age": np.minimum(2.0, self.targets.age / 5.0), "active": self.targets.active}
        if self.limits.targets_move:
            speed = self.targets.linear_velocity / 2.0
            targets |= {
                "moving_ahead": speed * self.targets.heading_cos,
                "moving_aside": speed * self.targets.heading_sin,
            }
        no_target = np.zeros((len(x), self.places))
        return by_name | {name: np.concatenate((no_target, column), axis=1) for name, column in targets.items()}

    def _next_targets(self) -> dict[str, Any]:
        """Return the features of the targets after a candidate, by name.

        These are the time to the next target, the times to the next two that no rival reaches earlier, and the density
        of targets near the candidate.
        """
        x, y = self.forward, self.left
        distance = np.sqrt(x * x + y * y)
        there = distance <= 1e-6  # the hunter keeps its heading in this case
        distance = np.where(there, 1.0, distance)
        cosine, sine = np.where(there, 1.0, x / distance), np.where(there, 0.0, y / distance)
        target_x, target_y = (one.T[self.places :, :, None] for one in (x, y))
        dx, dy = target_x - (x - BEHIND_M * cosine), target_y - (y - BEHIND_M * sine)  # (K, N, C)
        arrival = self._arrival_s(*own_frame(cosine, sine, dx, dy))
        another = self.alive.T[..., None] & (np.arange(self.places, x.shape[1])[:, None, None] != np.arange(x.shape[1]))
        arrival[~another] = NEVER_S
        wins = self.own_arrival + arrival < self.first_rival_arrival.T[self.places :, :, None]
        next_won, second_won = _two_smallest(np.where(wins, arrival, NEVER_S), FARTHEST_S)
        return {
            "next": arrival.min(axis=0, initial=FARTHEST_S),
            "next_won": next_won,
            "second_won": second_won,
            "density": (another / (1.0 + 0.5 * (dx * dx + dy * dy))).sum(axis=0),
        }

    def _first_rivals(self) -> Floats:
        """Return the features of the rivals that would be at a candidate first: (N, C, RIVALS * features of a rival).

        Rivals are in the order of their arrival; equal arrivals are in the order of their ranks.
        """
        features = (
            np.clip(self.rival_arrivals - self.own_arrival[:, None], -2.0, 2.0),
            self.best[:, 1:, None] == np.arange(self.own_arrival.shape[1]) - self.places,
            self.facing,
            self.far / LENGTH_M,
            self.rivals.linear_velocity / 2.0,
            self.rivals.mate if self.limits.teams else 0.0,
        )
        table = np.stack(np.broadcast_arrays(*features), axis=3)
        no_rival = FARTHEST_S, 0.0, 0.0, 0.0, 0.0, 0.0
        table[self.rival_arrivals >= NEVER_S] = no_rival
        order = np.argsort(self.rival_arrivals, axis=1, kind="stable")[:, :RIVALS]
        first = np.full((len(table), RIVALS, *table.shape[2:]), no_rival)
        first[:, : order.shape[1]] = table[np.arange(len(table))[:, None, None], order, np.arange(table.shape[2])]
        return first.swapaxes(1, 2).reshape(len(table), -1, RIVALS * len(_OF_RIVAL))


def _two_smallest(tables: Floats, limit: float) -> tuple[Floats, Floats]:
    """Return the smallest and the second smallest number at each place of some tables, both at most `limit`."""
    first = second = np.full(tables.shape[1:], limit)
    for table in tables:
        second = np.minimum(second, np.maximum(first, table))
        first = np.minimum(first, table)
    return first, second
