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


class _CandidateFeatures(NamedTuple):
    """What is told of each candidate, about -3 to 3 each: where each number stands."""

    forward: int
    left: int
    distance: int
    bearing_cos: int
    bearing_sin: int
    bearing: int
    arrival: int
    won: int
    next: int
    next_won: int
    second_won: int
    density: int
    wall_x: int
    wall_y: int
    preferred: int
    is_place: int
    is_ground: int
    age: int
    active: int
    moving_ahead: int
    moving_aside: int
    from_ground: int
    targets: int
    caught: int
    speed: int
    turn_rate: int
    time_left: int


class _RivalFeatures(NamedTuple):
    """And then of each of the rivals that would be there first."""

    margin: int
    bound_there: int
    facing_it: int
    distance: int
    speed: int
    mate: int


FEATURES: Final = (
    *_CandidateFeatures._fields,
    *(f"rival_{rival}_{name}" for rival in range(RIVALS) for name in _RivalFeatures._fields),
)
"""All of them, in order."""
_TO: Final = _CandidateFeatures(*range(len(_CandidateFeatures._fields)))
"""Where the first of them are written to, behind where a candidate's begin."""
_RIVAL_TO: Final = _RivalFeatures(*range(len(_RivalFeatures._fields)))
"""And those of a rival, behind where that one's begin."""
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


class _Race(NamedTuple):
    """Who would be where when, in scratch memory: by candidate (C), by rival (R), or by rival and candidate (R * C)."""

    mine: Any
    """The own arrival [s]: (C,)."""
    soonest: Any
    """The first rival's [s]: (C,)."""
    theirs: Any
    """Each rival's [s]: (R * C,)."""
    facing: Any
    """The cosine of the angle between a rival's heading and the candidate: (R * C,)."""
    far: Any
    """A rival's distance [m]: (R * C,)."""
    moving: Any
    """1 for a rival that drives: (R,)."""
    bound: Any
    """The target (from 0) that such a rival seems to drive to, else -1: (R,)."""


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


def _race_in(scratch: Any, shape: Any) -> Any:
    """The parts of the scratch memory by name."""
    candidates, rivals = shape.places + shape.targets, shape.rivals
    size, by_rival = rivals * candidates, 2 * candidates + 3 * rivals * candidates
    return _Race(
        scratch[:candidates],
        scratch[candidates : 2 * candidates],
        scratch[2 * candidates : 2 * candidates + size],
        scratch[2 * candidates + size : 2 * candidates + 2 * size],
        scratch[2 * candidates + 2 * size : by_rival],
        scratch[by_rival : by_rival + rivals],
        scratch[by_rival + rivals : by_rival + 2 * rivals],
    )


def _best_race(hunter: Any, shape: Any, first: Any, count: Any, race: Any) -> Any:
    """The target (from 0) whose race suits a hunter best, and by how much it is lost [s]; hunter -1 is oneself."""
    mine, theirs, moving = race.mine, race.theirs, race.moving
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
    x, y, cosine, sine = o[_OWN.x], o[_OWN.y], o[_OWN.heading_cos], o[_OWN.heading_sin]
    sum_forward, sum_left, points = 0.0, 0.0, 0
    for column in range(GROUND):
        dx = (column + 0.5) * step - x
        for row in range(GROUND):
            dy = (row + 0.5) * step - y
            forward = cosine * dx + sine * dy
            left = cosine * dy - sine * dx
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
        x, y, cosine, sine = o[_OWN.x], o[_OWN.y], o[_OWN.heading_cos], o[_OWN.heading_sin]
        for point in range(shape.places - 1):
            dx = (point // GRID + 0.5) * shape.side_m / GRID - x
            dy = (point % GRID + 0.5) * shape.side_m / GRID - y
            forward[1 + point] = cosine * dx + sine * dy
            left[1 + point] = cosine * dy - sine * dx
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


def _run_race(o: Any, shape: Any, first: Any, count: Any, forward: Any, left: Any, race: Any) -> None:
    """Write when everybody would be at each candidate, and where the rivals seem to drive."""
    mine, soonest, theirs, facing, far = race.mine, race.soonest, race.theirs, race.facing, race.far
    candidates = shape.places + shape.targets
    for place in range(candidates):
        mine[place] = _arrival_s(forward[place], left[place], shape)
        soonest[place] = NEVER_S
    for rival in range(shape.rivals):
        at = shape.first_rival + rival * shape.rival_stride
        there = o[at + _THERE] != 0.0
        race.moving[rival] = 1.0 if there and o[at + _RIVAL_SPEED] != 0.0 else 0.0
        race.bound[rival] = -1.0
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
        if race.moving[rival] > 0.0:
            race.bound[rival] = float(_best_race(rival, shape, first, count, race)[0])


def _preferred(shape: Any, first: Any, count: Any, race: Any) -> Any:
    """The candidate that a good scripted agent would take."""
    target, lost_by = _best_race(-1, shape, first, count, race)
    if target < 0 or (lost_by > GIVEN_UP_S and not shape.hosted):
        return 0
    return shape.places + target


def _describe_place(
    o: Any, shape: Any, place: Any, x: Any, y: Any, distance: Any, race: Any, features: Any, base: Any
) -> None:
    """Write where a candidate is, and what it is."""
    east = o[_OWN.x] + o[_OWN.heading_cos] * x - o[_OWN.heading_sin] * y
    north = o[_OWN.y] + o[_OWN.heading_sin] * x + o[_OWN.heading_cos] * y
    middle = 0.5 * shape.side_m
    features[base + _TO.forward] = x / LENGTH_M
    features[base + _TO.left] = y / LENGTH_M
    features[base + _TO.distance] = distance / LENGTH_M
    features[base + _TO.bearing_cos] = x / (distance + 1e-3)
    features[base + _TO.bearing_sin] = y / (distance + 1e-3)
    features[base + _TO.bearing] = abs(math.atan2(y, x)) / math.pi
    features[base + _TO.arrival] = min(race.mine[place], 2.0 * FARTHEST_S)
    features[base + _TO.won] = 1.0 if race.mine[place] < race.soonest[place] else 0.0
    features[base + _TO.wall_x] = abs(east - middle) / middle
    features[base + _TO.wall_y] = abs(north - middle) / middle
    features[base + _TO.is_place] = 1.0 if place < shape.places else 0.0
    features[base + _TO.is_ground] = 1.0 if place == 0 and not shape.hosted else 0.0
    if place >= shape.places:
        at = _FIRST_TARGET + (place - shape.places) * shape.target_stride
        features[base + _TO.age] = min(2.0, o[at + _AGE] / 5.0)
        features[base + _TO.active] = o[at + _ACTIVE]
        if shape.moving:
            features[base + _TO.moving_ahead] = o[at + _SPEED] * o[at + _COS] / 2.0
            features[base + _TO.moving_aside] = o[at + _SPEED] * o[at + _SIN] / 2.0


def _describe_next(
    shape: Any,
    first: Any,
    count: Any,
    place: Any,
    x: Any,
    y: Any,
    distance: Any,
    forward: Any,
    left: Any,
    race: Any,
    features: Any,
    base: Any,
) -> None:
    """Write what comes after a candidate: the next target, the next two that no rival reaches before, and how many lie
    about.
    """
    cosine, sine = (x / distance, y / distance) if distance > 1e-6 else (1.0, 0.0)
    from_x, from_y = x - BEHIND_M * cosine, y - BEHIND_M * sine
    own, soonest = race.mine[place], race.soonest
    next_s = next_won = second_won = FARTHEST_S
    density = 0.0
    for target in range(first, count):
        other = shape.places + target
        if other == place:
            continue
        dx, dy = forward[other] - from_x, left[other] - from_y
        arrival = _arrival_s(cosine * dx + sine * dy, cosine * dy - sine * dx, shape)
        density += 1.0 / (1.0 + 0.5 * (dx * dx + dy * dy))
        next_s = min(next_s, arrival)
        if own + arrival < soonest[other]:
            if arrival < next_won:
                next_won, second_won = arrival, next_won
            elif arrival < second_won:
                second_won = arrival
    features[base + _TO.next] = next_s
    features[base + _TO.next_won] = next_won
    features[base + _TO.second_won] = second_won
    features[base + _TO.density] = density


def _describe_rivals(o: Any, shape: Any, place: Any, race: Any, features: Any, base: Any) -> None:
    """Write of the rivals that would be there first: in the order of their arrival, and of their ranks where that is
    one.
    """
    candidates = shape.places + shape.targets
    theirs, own = race.theirs, race.mine[place]
    last, last_rival = -1.0, -1
    for nth in range(RIVALS):
        who, arrival = -1, NEVER_S
        for rival in range(shape.rivals):
            its = theirs[rival * candidates + place]
            if its < arrival and (its > last or (its == last and rival > last_rival)):
                who, arrival = rival, its
        to = base + len(_TO) + nth * len(_RIVAL_TO)
        if who < 0:
            features[to + _RIVAL_TO.margin] = FARTHEST_S
            continue
        last, last_rival = arrival, who
        at, there = shape.first_rival + who * shape.rival_stride, who * candidates + place
        features[to + _RIVAL_TO.margin] = max(-2.0, min(2.0, arrival - own))
        features[to + _RIVAL_TO.bound_there] = 1.0 if race.bound[who] == place - shape.places else 0.0
        features[to + _RIVAL_TO.facing_it] = race.facing[there]
        features[to + _RIVAL_TO.distance] = race.far[there] / LENGTH_M
        features[to + _RIVAL_TO.speed] = o[at + _RIVAL_SPEED] / 2.0
        if shape.teams:
            features[to + _RIVAL_TO.mate] = o[at + _MATE]


def _describe(o: Any, shape: Any, scratch: Any, forward: Any, left: Any, legal: Any, features: Any) -> Any:
    """Write the candidates of one hunter, and their features where zeros stood; what a scripted agent would take."""
    race = _race_in(scratch, shape)
    count, ground_forward, ground_left = _find_places(o, shape, forward, left)
    first = 1 if _is_as_good_as_caught(o, shape) else 0
    _run_race(o, shape, first, count, forward, left, race)
    preferred = _preferred(shape, first, count, race)
    targets, time_left = (count - first) / 8.0, min(1.0, o[_OWN.time_left] / 60.0)
    speed, turn_rate = o[_OWN.linear_velocity] / 2.0, o[_OWN.angular_velocity] / 4.0
    for place in range(shape.places + shape.targets):
        alive = place < shape.places or first <= place - shape.places < count
        legal[place] = 1.0 if alive else 0.0
        if not alive:
            continue
        base = place * _WIDTH
        x, y = forward[place], left[place]
        distance = math.sqrt(x * x + y * y)
        _describe_place(o, shape, place, x, y, distance, race, features, base)
        _describe_next(shape, first, count, place, x, y, distance, forward, left, race, features, base)
        features[base + _TO.preferred] = 1.0 if place == preferred else 0.0
        from_ground = math.sqrt((ground_forward - x) ** 2 + (ground_left - y) ** 2)
        features[base + _TO.from_ground] = min(2.0, from_ground / LENGTH_M)
        features[base + _TO.targets] = targets
        features[base + _TO.caught] = 1.0 * first
        features[base + _TO.speed] = speed
        features[base + _TO.turn_rate] = turn_rate
        features[base + _TO.time_left] = time_left
        _describe_rivals(o, shape, place, race, features, base)
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
    for function in (
        _arrival_s,
        _race_in,
        _best_race,
        _is_nearest,
        _own_ground,
        _find_places,
        _is_as_good_as_caught,
        _run_race,
        _preferred,
        _describe_place,
        _describe_next,
        _describe_rivals,
        _describe,
    ):
        space[function.__name__] = phase(FunctionType(function.__code__, space, function.__name__))
    return entry(FunctionType(_describe_all.__code__, space, _describe_all.__name__))
