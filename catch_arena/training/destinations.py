"""Where a hunter could go next, and what speaks for each place: the input of the networks that ship.

A *candidate* is a place: a target in view, the middle of one's own ground, or a waiting point. Each is described by the
same numbers, whatever the scenario, so that one network plays with any number of targets and rivals, in any arena.

In the shapes of arrays there are N hunters, C candidates (P places, then K targets) and R rivals.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.batch_policy import BatchView
from catch_arena.policy import Limits, View

VERSION: Final = 1
"""Of the features: a network that learned from others cannot read these."""

NEVER_S: Final = 1e3
"""The arrival of who is not there."""
RIVALS: Final = 3
"""As many rivals are described for each candidate: those that would arrive first."""
GRID: Final = 3
"""Waiting points lie on a grid of GRID x GRID."""
GROUND: Final = 5
"""One's own ground is found on a grid of GROUND x GROUND points."""
BEHIND_M: Final = 0.2
"""A hunter stands about this far before the middle of what it has caught."""
LONGEST_LEAD_S: Final = 1.5
"""Nobody knows where a moving target turns to after that."""
GIVEN_UP_S: Final = 0.4
"""A race that is lost by more is not run."""
LENGTH_M: Final = 3.0
"""Lengths are told in parts of this."""
FARTHEST_S: Final = 3.0
"""And times up to this."""
ROWS: Final = 64
"""Number of hunters that are described at a time: what is computed for more does not fit into a processor's caches."""

_OF_CANDIDATE: Final = (
    *("forward", "left", "distance", "bearing_cos", "bearing_sin", "bearing", "arrival", "won"),
    *("next", "next_won", "second_won", "density", "wall_x", "wall_y", "preferred", "is_place", "is_ground"),
    *("age", "active", "moving_ahead", "moving_aside", "from_ground"),
    *("targets", "caught", "speed", "turn_rate", "time_left"),
)
"""What is told of each candidate, about -3 to 3 each."""
_OF_RIVAL: Final = ("margin", "bound_there", "facing_it", "distance", "speed", "mate")
"""And then of each of the rivals that would be there first."""
FEATURES: Final = (*_OF_CANDIDATE, *(f"rival_{rival}_{name}" for rival in range(RIVALS) for name in _OF_RIVAL))
"""All of them, in order."""

Floats = NDArray[np.float64]


class Destinations(NamedTuple):
    """The candidates of N hunters: first the places (P), then the targets (K) by rank; C = P + K."""

    forward: NDArray[np.float64]
    """In the hunter's own frame [m]: (N, C)."""
    left: NDArray[np.float64]
    """(N, C)."""
    legal: NDArray[np.bool_]
    """(N, C)."""
    features: NDArray[np.float32]
    """(N, C, F)."""
    preferred: NDArray[np.int64]
    """What a good scripted agent would take: (N,)."""
    places: int
    """P: of a candidate c from P on, the target's rank is c - P + 1."""


def destinations(view: View | BatchView) -> Destinations:
    """Describe the candidates of one hunter, N = 1, or of many.

    Under target control the one place is where the hunter is, since to hold is all that it can do beside chasing. Else
    they are its own ground and the waiting points, and a target that is as good as caught is no candidate.
    """
    if isinstance(view, View):
        view = BatchView(np.array([view.observation]), np.zeros((1, 0), np.int8), view.limits)
    seen: Any = np.asarray(view.observations, np.float64)
    views = (BatchView(seen[at : at + ROWS], view.masks, view.limits) for at in range(0, max(1, len(seen)), ROWS))
    *tables, places = zip(*(_Block(some).described() for some in views), strict=True)
    return Destinations._make((*map(np.concatenate, tables), places[0]))


class _Block:
    """Some hunters, with what they see, (N, K) and (N, R), and when everybody would be at each candidate."""

    def __init__(self, view: BatchView) -> None:
        self.limits: Limits = view.limits
        self.hosted = view.limits.control == "target"
        self.own: Any = type(view.own)(*(column[:, None] for column in view.own))
        self.targets, self.rivals = view.targets, view.rivals
        self.ground = self._own_ground()
        places = [self.ground]
        if self.hosted:
            places = [np.zeros_like(self.ground)]
        else:
            places.append(self._in_own_frame(GRID))
        self.places = sum(points.shape[2] for points in places)
        self.forward, self.left = np.concatenate((*places, self._meetings()), axis=2)
        caught = self._as_good_as_caught()
        self.alive = (self.targets.present > 0) & ~caught
        self.caught = caught.any(axis=1, keepdims=True)
        self.mine = self._arrival_s(self.forward, self.left)
        dx, dy = (
            self.forward[:, None] - self.rivals.forward[..., None],
            self.left[:, None] - self.rivals.left[..., None],
        )
        cosine, sine = self.rivals.heading_cos[..., None], self.rivals.heading_sin[..., None]
        ahead, self.far = cosine * dx + sine * dy, np.sqrt(dx * dx + dy * dy)
        self.facing = ahead / (self.far + 1e-3)
        """The cosine of the angle between a rival's heading and the candidate, (N, R, C), as `far` [m] and `theirs`."""
        there = (self.rivals.present > 0)[..., None]
        self.theirs = np.where(there, self._arrival_s(ahead, cosine * dy - sine * dx), NEVER_S)
        self.soonest = self.theirs.min(axis=1, initial=NEVER_S)
        self.best, self.lost_by = self._best_races()

    def _in_own_frame(self, points: int) -> Floats:
        """A grid of points x points in the arena, as (forward, left): (2, N, points * points)."""
        middles, own = (np.arange(points) + 0.5) * self.limits.side_m / points, self.own
        dx, dy = np.repeat(middles, points) - own.x, np.tile(middles, points) - own.y
        cosine, sine = own.heading_cos, own.heading_sin
        return np.stack((cosine * dx + sine * dy, cosine * dy - sine * dx))

    def _is_nearest(self, forward: Floats, left: Floats) -> NDArray[np.bool_]:
        """Whether no rival is nearer to points of the own frame: (N, points)."""
        dx, dy = forward[:, None] - self.rivals.forward[..., None], left[:, None] - self.rivals.left[..., None]
        nearer = dx * dx + dy * dy < (forward * forward + left * left)[:, None]
        nearest: NDArray[np.bool_] = ~(nearer & (self.rivals.present > 0)[..., None]).any(axis=1)
        return nearest

    def _own_ground(self) -> Floats:
        """The mean of those points of the arena that no rival is nearer to, in the own frame: (2, N, 1)."""
        points = self._in_own_frame(GROUND)
        own = self._is_nearest(*points)
        mean: Floats = (points * own).sum(axis=2, keepdims=True) / np.maximum(1, own.sum(axis=1))[:, None]
        return mean

    def _meetings(self) -> Floats:
        """Where targets can be met: the time to that place, and the place by that time: (2, N, K)."""
        now = np.stack((self.targets.forward, self.targets.left))
        if not self.limits.targets_move:
            return now
        way = self.targets.linear_velocity * np.stack((self.targets.heading_cos, self.targets.heading_sin))
        place = now
        for _ in range(2):
            place = now + way * np.minimum(LONGEST_LEAD_S, self._arrival_s(*place))
        return place

    def _as_good_as_caught(self) -> NDArray[np.bool_]:
        """Whether the nearest target is requested for oneself: within reach, and no rival is nearer to it: (N, K)."""
        forward, left = self.targets.forward[:, :1], self.targets.left[:, :1]
        caught: NDArray[np.bool_] = self.targets.present > 0
        within = forward * forward + left * left < (0.999 * self.limits.reach_m) ** 2
        caught[:, :1] &= within & self._is_nearest(forward, left) & (not self.hosted)
        caught[:, 1:] = False
        return caught

    def _arrival_s(self, forward: Floats, left: Floats) -> Floats:
        """`contested_by_time.arrival_s`."""
        way = np.maximum(0.0, np.sqrt(forward * forward + left * left) - self.limits.reach_m)
        turn: Floats = 0.5 * np.abs(np.arctan2(left, forward)) / self.limits.max_turn_rate_radps
        return way / self.limits.max_speed_mps + turn

    def _best_races(self) -> tuple[NDArray[np.int64], Floats]:
        """The target (from 0) whose race suits oneself and then each rival best, else -1, and by how much it is lost
        [s]: (N, 1 + R).
        """
        races = np.concatenate((self.mine[:, None], self.theirs), axis=1)[..., self.places :]
        moving = (self.rivals.present > 0) & (self.rivals.linear_velocity != 0)
        racing = np.concatenate((np.ones((len(moving), 1), np.bool_), moving), axis=1)
        times = np.where(racing[..., None], races, NEVER_S)
        first, second = _two_least(times.swapaxes(0, 1), NEVER_S)
        others = np.where(times == first[:, None], second[:, None], first[:, None])
        late = np.where(self.alive[:, None], times - others, NEVER_S)
        won = late <= 0.0
        cost = np.where(won, times, NEVER_S + late)
        best, wins = cost.argmin(axis=2), won.any(axis=2)
        lost_by: Floats = np.where(wins, 0.0, late.min(axis=2))
        return np.where(racing & self.alive.any(axis=1)[:, None], best, -1), lost_by

    def described(self) -> Destinations:
        """All that is told of these hunters."""
        given_up = (self.lost_by[:, 0] > GIVEN_UP_S) & (not self.hosted)
        preferred = np.where((self.best[:, 0] < 0) | given_up, 0, self.places + self.best[:, 0])
        legal = np.concatenate((np.ones((len(self.alive), self.places), np.bool_), self.alive), axis=1)
        features = np.zeros((*legal.shape, len(FEATURES)), np.float32)
        told = {**self._candidates(), **self._what_comes_next()}
        told["preferred"] = np.arange(legal.shape[1]) == preferred[:, None]
        for name, values in told.items():
            features[..., _OF_CANDIDATE.index(name)] = values
        features[..., len(_OF_CANDIDATE) :] = self._first_rivals()
        features[~legal] = 0.0
        return Destinations(self.forward, self.left, legal, features, preferred, self.places)

    def _candidates(self) -> dict[str, Any]:
        """Where candidates are, what they are, and what is told of the hunter itself."""
        x, y, own, middle = self.forward, self.left, self.own, 0.5 * self.limits.side_m
        distance, number = np.sqrt(x * x + y * y), np.arange(x.shape[1])
        east = own.x + own.heading_cos * x - own.heading_sin * y
        north = own.y + own.heading_sin * x + own.heading_cos * y
        from_ground = np.sqrt((self.ground[0] - x) ** 2 + (self.ground[1] - y) ** 2)
        told = {
            "forward": x / LENGTH_M,
            "left": y / LENGTH_M,
            "distance": distance / LENGTH_M,
            "bearing_cos": x / (distance + 1e-3),
            "bearing_sin": y / (distance + 1e-3),
            "bearing": np.abs(np.arctan2(y, x)) / np.pi,
            "arrival": np.minimum(self.mine, 2.0 * FARTHEST_S),
            "won": self.mine < self.soonest,
            "wall_x": np.abs(east - middle) / middle,
            "wall_y": np.abs(north - middle) / middle,
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
        return told | {name: np.concatenate((no_target, column), axis=1) for name, column in targets.items()}

    def _what_comes_next(self) -> dict[str, Any]:
        """What comes after a candidate: the next target, the next two that no rival reaches before, and how many lie
        about.
        """
        x, y = self.forward, self.left
        distance = np.sqrt(x * x + y * y)
        there = distance <= 1e-6  # and then it faces ahead
        distance = np.where(there, 1.0, distance)
        cosine, sine = np.where(there, 1.0, x / distance), np.where(there, 0.0, y / distance)
        target_x, target_y = (one.T[self.places :, :, None] for one in (x, y))
        dx, dy = target_x - (x - BEHIND_M * cosine), target_y - (y - BEHIND_M * sine)  # (K, N, C)
        arrival = self._arrival_s(cosine * dx + sine * dy, cosine * dy - sine * dx)
        another = self.alive.T[..., None] & (np.arange(self.places, x.shape[1])[:, None, None] != np.arange(x.shape[1]))
        arrival[~another] = NEVER_S
        wins = self.mine + arrival < self.soonest.T[self.places :, :, None]
        next_won, second_won = _two_least(np.where(wins, arrival, NEVER_S), FARTHEST_S)
        return {
            "next": arrival.min(axis=0, initial=FARTHEST_S),
            "next_won": next_won,
            "second_won": second_won,
            "density": (another / (1.0 + 0.5 * (dx * dx + dy * dy))).sum(axis=0),
        }

    def _first_rivals(self) -> Floats:
        """What is told of the rivals that would be at a candidate first: in the order of their arrival, and of their
        ranks where that is one: (N, C, RIVALS * F).
        """
        features = (
            np.clip(self.theirs - self.mine[:, None], -2.0, 2.0),
            self.best[:, 1:, None] == np.arange(self.mine.shape[1]) - self.places,
            self.facing,
            self.far / LENGTH_M,
            self.rivals.linear_velocity[..., None] / 2.0,
            self.rivals.mate[..., None] if self.limits.teams else 0.0,
        )
        told = np.stack(np.broadcast_arrays(*features), axis=3)
        nobody = FARTHEST_S, 0.0, 0.0, 0.0, 0.0, 0.0
        told[self.theirs >= NEVER_S] = nobody
        order = np.argsort(self.theirs, axis=1, kind="stable")[:, :RIVALS]
        first = np.full((len(told), RIVALS, *told.shape[2:]), nobody)
        first[:, : order.shape[1]] = told[np.arange(len(told))[:, None, None], order, np.arange(told.shape[2])]
        return first.swapaxes(1, 2).reshape(len(told), -1, RIVALS * len(_OF_RIVAL))


def _two_least(tables: Floats, most: float) -> tuple[Floats, Floats]:
    """The least and the second least number at each place of some tables, `most` at most."""
    first = second = np.full(tables.shape[1:], most)
    for table in tables:
        second = np.minimum(second, np.maximum(first, table))
        first = np.minimum(first, table)
    return first, second
