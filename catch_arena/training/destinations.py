"""Where a hunter could go next, and what speaks for each place: the input of the networks that ship.

A *candidate* is a place: a target in view, the middle of one's own ground, or a waiting point. Each is described by the
same numbers, whatever the scenario, so that one network plays with any number of targets and rivals, in any arena.
"""

import math
from collections.abc import Callable
from functools import cache, lru_cache
from types import FunctionType
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.batch_policy import BatchView
from catch_arena.layout import MovingTargetFeatures, RivalFeatures, SelfFeatures, TeamRivalFeatures
from catch_arena.policy import Limits, View, first_rival_column, rival_features, target_features

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

FEATURES: Final = (
    "forward",
    "left",
    "distance",
    "bearing_cos",
    "bearing_sin",
    "bearing",
    "arrival",
    "won",
    "next",
    "next_won",
    "second_won",
    "density",
    "wall_x",
    "wall_y",
    "preferred",
    "is_place",
    "is_ground",
    "age",
    "active",
    "moving_ahead",
    "moving_aside",
    "from_ground",
    "targets",
    "caught",
    "speed",
    "turn_rate",
    "time_left",
    *(
        f"rival_{rival}_{name}"
        for rival in range(RIVALS)
        for name in ("margin", "bound_there", "facing_it", "distance", "speed", "mate")
    ),
)
"""What is told of each candidate, in order; about -3 to 3 each."""
_OWN: Final = SelfFeatures(*range(len(SelfFeatures._fields)))
_FIRST_TARGET: Final = len(_OWN)
_ASIDE, _THERE, _AGE, _ACTIVE, _COS, _SIN, _SPEED = (
    MovingTargetFeatures._fields.index(name)
    for name in ("left", "present", "age", "active", "heading_cos", "heading_sin", "linear_velocity")
)
"""Of a target's columns, behind `forward`; the first three are a rival's too."""
_RIVAL_COS, _RIVAL_SIN, _RIVAL_SPEED = (
    RivalFeatures._fields.index(name) for name in ("heading_cos", "heading_sin", "linear_velocity")
)
_MATE: Final = TeamRivalFeatures._fields.index("mate")
_WIDTH: Final = len(FEATURES)
_OF_RIVALS: Final = FEATURES.index("rival_0_margin")
_OF_EACH: Final = (_WIDTH - _OF_RIVALS) // RIVALS


class _Shape(NamedTuple):
    """An arena and its observation in numbers, as compiled code takes them."""

    places: int
    targets: int
    rivals: int
    target_stride: int
    first_rival: int
    rival_stride: int
    side_m: float
    reach_m: float
    speed_mps: float
    turn_rate_radps: float
    hosted: bool
    moving: bool
    teams: bool


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


def destinations(view: View) -> Destinations:
    """The candidates of one hunter, N = 1.

    Under target control the one place is where the hunter is, since to hold is all that it can do beside chasing. Else
    they are its own ground and the waiting points, and a target that is as good as caught is no candidate.
    """
    shape = _shape(view.limits)
    candidates = shape.places + shape.targets
    forward, left, legal = ([0.0] * candidates for _ in range(3))
    features = [0.0] * (candidates * _WIDTH)
    scratch = [0.0] * _scratch_size(shape)
    preferred = _describe(view.observation, shape, scratch, forward, left, legal, features)
    return Destinations(
        np.array([forward]),
        np.array([left]),
        np.array([legal]) > 0,
        np.array(features, np.float32).reshape(1, candidates, _WIDTH),
        np.array([preferred]),
        shape.places,
    )


def destinations_of_batch(view: BatchView) -> Destinations:
    """The same of N hunters: compiled, which takes some seconds when it is used first."""
    shape = _shape(view.limits)
    rows, candidates = len(view.observations), shape.places + shape.targets
    forward, left, legal = (np.zeros((rows, candidates)) for _ in range(3))
    features = np.zeros((rows, candidates * _WIDTH), np.float32)
    preferred = np.empty(rows, np.int64)
    observations = np.asarray(view.observations, np.float64)
    _compiled()(observations, shape, np.empty(_scratch_size(shape)), forward, left, legal, features, preferred)
    return Destinations(forward, left, legal > 0, features.reshape(rows, candidates, _WIDTH), preferred, shape.places)


@lru_cache(maxsize=64)
def _shape(limits: Limits) -> _Shape:
    hosted = limits.control == "target"
    return _Shape(
        1 if hosted else 1 + GRID * GRID,
        limits.targets_seen,
        limits.hunters_seen,
        len(target_features(limits)._fields),
        first_rival_column(limits),
        len(rival_features(limits)._fields),
        limits.side_m,
        limits.reach_m,
        limits.max_speed_mps,
        limits.max_turn_rate_radps,
        hosted,
        limits.targets_move,
        limits.teams,
    )


def _scratch_size(shape: _Shape) -> int:
    candidates = shape.places + shape.targets
    return 2 * candidates + 3 * shape.rivals * candidates + 2 * shape.rivals


# one source for a match's single views, in plain Python, and for training's batches, compiled


def _arrival_s(forward: Any, left: Any, shape: Any) -> Any:
    """`contested_by_time.arrival_s`."""
    way = max(0.0, math.sqrt(forward * forward + left * left) - shape.reach_m)
    return way / shape.speed_mps + 0.5 * abs(math.atan2(left, forward)) / shape.turn_rate_radps


def _best_race(hunter: Any, shape: Any, first: Any, count: Any, mine: Any, theirs: Any, moving: Any) -> Any:
    """The target (from 0) whose race suits a hunter best, and by how much it is lost [s]; hunter -1 is oneself."""
    candidates = shape.places + shape.targets
    won, lost, soonest, closest = -1, -1, NEVER_S, NEVER_S
    for target in range(first, count):
        place = shape.places + target
        arrival = mine[place] if hunter < 0 else theirs[hunter * candidates + place]
        if arrival >= soonest:
            continue
        others = NEVER_S if hunter < 0 else mine[place]
        for rival in range(shape.rivals):
            if rival != hunter and moving[rival] > 0.0:
                others = min(others, theirs[rival * candidates + place])
        if arrival <= others:
            won, soonest = target, arrival
        elif arrival - others < closest:
            lost, closest = target, arrival - others
    if won >= 0:
        return won, 0.0
    return lost, closest


def _is_nearest(o: Any, shape: Any, forward: Any, left: Any) -> Any:
    """Whether no rival is nearer to a point of the own frame."""
    distance = forward * forward + left * left
    for rival in range(shape.rivals):
        at = shape.first_rival + rival * shape.rival_stride
        if o[at + _THERE] == 0.0:
            break
        if (forward - o[at]) ** 2 + (left - o[at + _ASIDE]) ** 2 < distance:
            return False
    return True


def _own_ground(o: Any, shape: Any) -> Any:
    """The mean of those points of the arena that no rival is nearer to, in the own frame."""
    step = shape.side_m / GROUND
    sum_forward, sum_left, points = 0.0, 0.0, 0
    for column in range(GROUND):
        dx = (column + 0.5) * step - o[_OWN.x]
        for row in range(GROUND):
            dy = (row + 0.5) * step - o[_OWN.y]
            forward = o[_OWN.heading_cos] * dx + o[_OWN.heading_sin] * dy
            left = o[_OWN.heading_cos] * dy - o[_OWN.heading_sin] * dx
            if _is_nearest(o, shape, forward, left):
                sum_forward += forward
                sum_left += left
                points += 1
    if points == 0:
        return 0.0, 0.0
    return sum_forward / points, sum_left / points


def _find_places(o: Any, shape: Any, forward: Any, left: Any) -> Any:
    """Write where the candidates are; how many targets are in view."""
    ground_forward, ground_left = _own_ground(o, shape)
    if not shape.hosted:
        forward[0], left[0] = ground_forward, ground_left
        for point in range(shape.places - 1):
            dx = (point // GRID + 0.5) * shape.side_m / GRID - o[_OWN.x]
            dy = (point % GRID + 0.5) * shape.side_m / GRID - o[_OWN.y]
            forward[1 + point] = o[_OWN.heading_cos] * dx + o[_OWN.heading_sin] * dy
            left[1 + point] = o[_OWN.heading_cos] * dy - o[_OWN.heading_sin] * dx
    count = 0
    for target in range(shape.targets):
        at = _FIRST_TARGET + target * shape.target_stride
        place = shape.places + target
        forward[place], left[place] = o[at], o[at + _ASIDE]
        if o[at + _THERE] == 0.0:
            continue
        count += 1
        if shape.moving:  # where it can be met: the time to that place, and the place by that time
            for _ in range(2):
                lead = min(LONGEST_LEAD_S, _arrival_s(forward[place], left[place], shape))
                forward[place] = o[at] + o[at + _SPEED] * o[at + _COS] * lead
                left[place] = o[at + _ASIDE] + o[at + _SPEED] * o[at + _SIN] * lead
    return count, ground_forward, ground_left


def _is_as_good_as_caught(o: Any, shape: Any) -> Any:
    """Whether the nearest target is within reach and no rival is nearer to it: it is requested for oneself."""
    if shape.hosted or o[_FIRST_TARGET + _THERE] == 0.0:
        return False
    forward, left = o[_FIRST_TARGET], o[_FIRST_TARGET + _ASIDE]
    if forward * forward + left * left >= (0.999 * shape.reach_m) ** 2:
        return False
    return _is_nearest(o, shape, forward, left)


def _describe(o: Any, shape: Any, scratch: Any, forward: Any, left: Any, legal: Any, features: Any) -> Any:
    """Write the candidates of one hunter, and their features where zeros stood; what a scripted agent would take."""
    places, candidates = shape.places, shape.places + shape.targets
    mine = scratch[:candidates]
    size = shape.rivals * candidates
    theirs, facing = scratch[candidates : candidates + size], scratch[candidates + size : candidates + 2 * size]
    far = scratch[candidates + 2 * size : candidates + 3 * size]
    rest = candidates + 3 * size
    moving, bound = scratch[rest : rest + shape.rivals], scratch[rest + shape.rivals : rest + 2 * shape.rivals]
    soonest = scratch[rest + 2 * shape.rivals : rest + 2 * shape.rivals + candidates]

    count, ground_forward, ground_left = _find_places(o, shape, forward, left)
    first = 1 if _is_as_good_as_caught(o, shape) else 0
    for place in range(candidates):
        alive = place < places or first <= place - places < count
        legal[place] = 1.0 if alive else 0.0
        mine[place] = _arrival_s(forward[place], left[place], shape)
        soonest[place] = NEVER_S
    for rival in range(shape.rivals):
        at = shape.first_rival + rival * shape.rival_stride
        there = o[at + _THERE] != 0.0
        moving[rival] = 1.0 if there and o[at + _RIVAL_SPEED] != 0.0 else 0.0
        bound[rival] = -1.0
        cosine, sine = o[at + _RIVAL_COS], o[at + _RIVAL_SIN]
        for place in range(candidates):
            dx, dy = forward[place] - o[at], left[place] - o[at + _ASIDE]
            ahead, aside = cosine * dx + sine * dy, cosine * dy - sine * dx
            distance = math.sqrt(dx * dx + dy * dy)
            theirs[rival * candidates + place] = _arrival_s(ahead, aside, shape) if there else NEVER_S
            soonest[place] = min(soonest[place], theirs[rival * candidates + place])
            facing[rival * candidates + place] = ahead / (distance + 1e-3)
            far[rival * candidates + place] = distance
    for rival in range(shape.rivals):
        if moving[rival] > 0.0:
            bound[rival] = float(_best_race(rival, shape, first, count, mine, theirs, moving)[0])
    race, lost_by = _best_race(-1, shape, first, count, mine, theirs, moving)
    preferred = places + race
    if race < 0 or (lost_by > GIVEN_UP_S and not shape.hosted):
        preferred = 0

    for place in range(candidates):
        if legal[place] == 0.0:
            continue
        base = place * _WIDTH
        x, y = forward[place], left[place]
        distance = math.sqrt(x * x + y * y)

        # from there on: the next target, the next two that no rival reaches before, how many lie about
        cosine, sine = (x / distance, y / distance) if distance > 1e-6 else (1.0, 0.0)
        from_x, from_y = x - BEHIND_M * cosine, y - BEHIND_M * sine
        next_s = next_won = second_won = FARTHEST_S
        density = 0.0
        for target in range(first, count):
            other = places + target
            if other == place:
                continue
            dx, dy = forward[other] - from_x, left[other] - from_y
            arrival = _arrival_s(cosine * dx + sine * dy, cosine * dy - sine * dx, shape)
            density += 1.0 / (1.0 + 0.5 * (dx * dx + dy * dy))
            next_s = min(next_s, arrival)
            if mine[place] + arrival < soonest[other]:
                if arrival < next_won:
                    next_won, second_won = arrival, next_won
                elif arrival < second_won:
                    second_won = arrival

        east = o[_OWN.x] + o[_OWN.heading_cos] * x - o[_OWN.heading_sin] * y
        north = o[_OWN.y] + o[_OWN.heading_sin] * x + o[_OWN.heading_cos] * y
        middle = 0.5 * shape.side_m
        features[base] = x / LENGTH_M
        features[base + 1] = y / LENGTH_M
        features[base + 2] = distance / LENGTH_M
        features[base + 3] = x / (distance + 1e-3)
        features[base + 4] = y / (distance + 1e-3)
        features[base + 5] = abs(math.atan2(y, x)) / math.pi
        features[base + 6] = min(mine[place], 2.0 * FARTHEST_S)
        features[base + 7] = 1.0 if mine[place] < soonest[place] else 0.0
        features[base + 8] = next_s
        features[base + 9] = next_won
        features[base + 10] = second_won
        features[base + 11] = density
        features[base + 12] = abs(east - middle) / middle
        features[base + 13] = abs(north - middle) / middle
        features[base + 14] = 1.0 if place == preferred else 0.0
        features[base + 15] = 1.0 if place < places else 0.0
        features[base + 16] = 1.0 if place == 0 and not shape.hosted else 0.0
        if place >= places:
            at = _FIRST_TARGET + (place - places) * shape.target_stride
            features[base + 17] = min(2.0, o[at + _AGE] / 5.0)
            features[base + 18] = o[at + _ACTIVE]
            if shape.moving:
                features[base + 19] = o[at + _SPEED] * o[at + _COS] / 2.0
                features[base + 20] = o[at + _SPEED] * o[at + _SIN] / 2.0
        from_ground = math.sqrt((ground_forward - x) ** 2 + (ground_left - y) ** 2)
        features[base + 21] = min(2.0, from_ground / LENGTH_M)
        features[base + 22] = (count - first) / 8.0
        features[base + 23] = 1.0 * first
        features[base + 24] = o[_OWN.linear_velocity] / 2.0
        features[base + 25] = o[_OWN.angular_velocity] / 4.0
        features[base + 26] = min(1.0, o[_OWN.time_left] / 60.0)

        last, last_rival = -1.0, -1  # the rivals in the order of their arrival, and of their ranks where that is one
        for nth in range(RIVALS):
            who, arrival = -1, NEVER_S
            for rival in range(shape.rivals):
                its = theirs[rival * candidates + place]
                later = its > last or (its == last and rival > last_rival)
                if later and its < arrival:
                    who, arrival = rival, its
            column = base + _OF_RIVALS + nth * _OF_EACH
            if who < 0:
                features[column] = FARTHEST_S
                continue
            last, last_rival = arrival, who
            at = shape.first_rival + who * shape.rival_stride
            features[column] = max(-2.0, min(2.0, arrival - mine[place]))
            features[column + 1] = 1.0 if bound[who] == place - places else 0.0
            features[column + 2] = facing[who * candidates + place]
            features[column + 3] = far[who * candidates + place] / LENGTH_M
            features[column + 4] = o[at + _RIVAL_SPEED] / 2.0
            if shape.teams:
                features[column + 5] = o[at + _MATE]
    return preferred


def _describe_all(
    observations: Any, shape: Any, scratch: Any, forward: Any, left: Any, legal: Any, features: Any, preferred: Any
) -> None:
    for row in range(len(observations)):
        preferred[row] = _describe(
            observations[row], shape, scratch, forward[row], left[row], legal[row], features[row]
        )


@cache
def _compiled() -> Callable[..., None]:
    """`_describe_all`, compiled: copies of the functions above, since those stay plain Python."""
    from catch_arena.core.jit import entry, phase  # a match must not wait for the compiler

    space = dict(globals())
    for function in (_arrival_s, _best_race, _is_nearest, _own_ground, _find_places, _is_as_good_as_caught, _describe):
        space[function.__name__] = phase(FunctionType(function.__code__, space, function.__name__))
    return entry(FunctionType(_describe_all.__code__, space, _describe_all.__name__))
