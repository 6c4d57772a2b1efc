"""What some shipped agents do, compiled: their `act_batch`, for batches of thousands.

An arena's step takes 0.2 microseconds a hunter, and NumPy would take 7 to choose one target. Here is what `act` of
agents/ says, rule by rule and under the same names; tests/training holds that both act alike.
"""

import math
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.agents.intercept import LONGEST_LEAD_S, LOOKS
from catch_arena.agents.patrol import BRAKE_GAIN, GRID, SPAWN_LOW_M, SPAWN_WALL_M, TURN_GAIN
from catch_arena.agents.triage import lost_by_s
from catch_arena.batch_policy import BatchView
from catch_arena.core.jit import entry, rule
from catch_arena.core.math import PI, atan2, clamp
from catch_arena.layout import MovingTargetFeatures, RivalFeatures, SelfFeatures
from catch_arena.policy import Limits, first_rival_column, rival_features, target_features

Seen = NDArray[np.float64]
"""Observations: (N, D)."""
Point = tuple[float, float]
"""(forward, left) in a hunter's own frame [m], or (speed, turn rate) as parts of the limits."""

_OWN, _TARGET, _RIVAL = SelfFeatures._fields, MovingTargetFeatures._fields, RivalFeatures._fields
_X, _Y, _COS, _SIN = (_OWN.index(name) for name in ("x", "y", "heading_cos", "heading_sin"))
_FORWARD, _LEFT, _PRESENT = 0, 1, 2  # of targets and of rivals
_TARGET_COS, _TARGET_SIN, _TARGET_SPEED = (_TARGET.index(n) for n in ("heading_cos", "heading_sin", "linear_velocity"))
_RIVAL_COS, _RIVAL_SIN, _RIVAL_SPEED = (_RIVAL.index(n) for n in ("heading_cos", "heading_sin", "linear_velocity"))
_NONE: Final = -1
"""No target."""


class Rules(NamedTuple):
    """Where things stand in an observation, what a hunter can do, and the constants of the agents. Compiled code is
    handed them: its cache would not notice that they have changed elsewhere.
    """

    first_target: int
    target_columns: int
    first_rival: int
    rival_columns: int
    end: int
    side_m: float
    reach_m: float
    speed_mps: float
    turn_rate_radps: float
    targets_move: bool
    lost_by_s: float
    turn_gain: float = TURN_GAIN
    brake_gain: float = BRAKE_GAIN
    grid: int = GRID
    spawn_low_m: float = SPAWN_LOW_M
    spawn_wall_m: float = SPAWN_WALL_M
    looks: int = LOOKS
    longest_lead_s: float = LONGEST_LEAD_S

    @classmethod
    def of(cls, limits: Limits) -> "Rules":
        """Those of one kind of hunter."""
        first, columns = first_rival_column(limits), len(rival_features(limits)._fields)
        return cls(
            first_target=len(_OWN),
            target_columns=len(target_features(limits)._fields),
            first_rival=first,
            rival_columns=columns,
            end=first + columns * limits.hunters_seen,
            side_m=limits.side_m,
            reach_m=limits.reach_m,
            speed_mps=limits.max_speed_mps,
            turn_rate_radps=limits.max_turn_rate_radps,
            targets_move=limits.targets_move,
            lost_by_s=lost_by_s(limits),
        )


def contested(view: BatchView) -> NDArray[np.int64]:
    """Ranks: (N,)."""
    return _choices(_contested, view)


def contested_by_time(view: BatchView) -> NDArray[np.int64]:
    """Ranks: (N,)."""
    return _choices(_contested_by_time, view)


def patrol(view: BatchView) -> NDArray[np.float64]:
    """Speeds and turn rates: (N, 2)."""
    return _commands(_patrol, view)


def triage(view: BatchView) -> NDArray[np.float64]:
    """Speeds and turn rates: (N, 2)."""
    return _commands(_triage, view)


def intercept(view: BatchView) -> NDArray[np.float64]:
    """Speeds and turn rates: (N, 2)."""
    return _commands(_intercept, view)


def _choices(compiled: Any, view: BatchView) -> NDArray[np.int64]:
    seen = np.ascontiguousarray(view.observations, dtype=np.float64)
    ranks = np.empty(len(seen), dtype=np.int64)
    compiled(seen, Rules.of(view.limits), ranks)
    return ranks


def _commands(compiled: Any, view: BatchView) -> NDArray[np.float64]:
    seen = np.ascontiguousarray(view.observations, dtype=np.float64)
    commands = np.empty((len(seen), 2))
    compiled(seen, Rules.of(view.limits), commands)
    return commands


@entry
def _contested(seen: Seen, rules: Rules, ranks: NDArray[np.int64]) -> None:
    for row in range(len(seen)):
        ranks[row] = 0
        least = math.inf
        for target in range(rules.first_target, rules.first_rival, rules.target_columns):
            if seen[row, target + _PRESENT] == 0.0:
                break
            forward, left = seen[row, target + _FORWARD], seen[row, target + _LEFT]
            mine, theirs = forward * forward + left * left, nearest_rival_m2(seen, row, forward, left, rules)
            behind = math.sqrt(mine) - math.sqrt(theirs)
            if behind < least:
                least = behind
                ranks[row] = 1 + (target - rules.first_target) // rules.target_columns
            if behind <= 0.0:
                ranks[row] = 1 + (target - rules.first_target) // rules.target_columns
                break


@entry
def _contested_by_time(seen: Seen, rules: Rules, ranks: NDArray[np.int64]) -> None:
    for row in range(len(seen)):
        target = best_race(seen, row, rules.first_target, math.inf, rules)
        ranks[row] = 0 if target == _NONE else 1 + (target - rules.first_target) // rules.target_columns


@entry
def _patrol(seen: Seen, rules: Rules, commands: NDArray[np.float64]) -> None:
    for row in range(len(seen)):
        target = best_race(seen, row, rules.first_target, math.inf, rules)
        if target == _NONE:
            commands[row, 0], commands[row, 1] = rest(seen, row, rules)
        else:
            commands[row, 0], commands[row, 1] = drive(seen[row, target + _FORWARD], seen[row, target + _LEFT], rules)


@entry
def _triage(seen: Seen, rules: Rules, commands: NDArray[np.float64]) -> None:
    for row in range(len(seen)):
        first = rules.first_target
        if as_good_as_caught(seen, row, rules):
            first += rules.target_columns
        target = best_race(seen, row, first, rules.lost_by_s, rules)
        if target == _NONE:
            commands[row, 0], commands[row, 1] = rest(seen, row, rules)
        else:
            forward, left = meeting_point(seen, row, target, rules)
            commands[row, 0], commands[row, 1] = drive(forward, left, rules)


@entry
def _intercept(seen: Seen, rules: Rules, commands: NDArray[np.float64]) -> None:
    for row in range(len(seen)):
        least = math.inf
        goal = middle_of_own_ground(seen, row, rules) if seen[row, rules.first_target + _PRESENT] == 0.0 else (0.0, 0.0)
        for target in range(rules.first_target, rules.first_rival, rules.target_columns):
            if seen[row, target + _PRESENT] == 0.0:
                break
            forward, left = meeting_point(seen, row, target, rules)
            mine = arrival_s(forward, left, rules)
            if mine >= least:
                continue
            behind = mine - rivals_way_s(seen, row, forward, left, rules)
            cost = mine + 2.0 * behind if behind > 0.0 else mine
            if cost < least:
                least = cost
                goal = forward, left
        commands[row, 0], commands[row, 1] = drive(goal[0], goal[1], rules)


@rule
def nearest_rival_m2(seen: Seen, row: int, forward: float, left: float, rules: Rules) -> float:
    """`contested.nearest_rival_m`, squared."""
    least = math.inf
    for rival in range(rules.first_rival, rules.end, rules.rival_columns):
        if seen[row, rival + _PRESENT] == 0.0:
            break
        dx, dy = forward - seen[row, rival + _FORWARD], left - seen[row, rival + _LEFT]
        least = min(least, dx * dx + dy * dy)
    return least


@rule
def best_race(seen: Seen, row: int, first: int, lost_by_s: float, rules: Rules) -> int:
    """`contested_by_time.best_race`, from the target in the column `first` on; none that is lost by `lost_by_s`."""
    soonest, closest = math.inf, lost_by_s
    won = lost = _NONE
    for target in range(first, rules.first_rival, rules.target_columns):
        if seen[row, target + _PRESENT] == 0.0:
            break
        forward, left = seen[row, target + _FORWARD], seen[row, target + _LEFT]
        if way_s(forward, left, rules) >= soonest:
            continue  # whatever the turn
        mine = arrival_s(forward, left, rules)
        if mine >= soonest:
            continue
        late = mine - rivals_arrival_s(seen, row, forward, left, mine, rules)
        if late <= 0.0:
            won, soonest = target, mine
        elif late < closest:
            lost, closest = target, late
    return lost if won == _NONE else won


@rule
def rivals_arrival_s(seen: Seen, row: int, forward: float, left: float, mine: float, rules: Rules) -> float:
    """`contested_by_time.rivals_arrival_s`; where that is not sooner than `mine`, it is `mine`, and found sooner."""
    soonest = mine
    for rival in range(rules.first_rival, rules.end, rules.rival_columns):
        if seen[row, rival + _RIVAL_SPEED] == 0.0:  # who is absent has none either
            continue
        dx, dy = forward - seen[row, rival + _FORWARD], left - seen[row, rival + _LEFT]
        if way_s(dx, dy, rules) >= soonest:
            continue
        cosine, sine = seen[row, rival + _RIVAL_COS], seen[row, rival + _RIVAL_SIN]
        soonest = min(soonest, arrival_s(cosine * dx + sine * dy, cosine * dy - sine * dx, rules))
    return soonest


@rule
def rivals_way_s(seen: Seen, row: int, forward: float, left: float, rules: Rules) -> float:
    """What `intercept.cost_s` takes rivals to need."""
    least = math.inf
    for rival in range(rules.first_rival, rules.end, rules.rival_columns):
        if seen[row, rival + _RIVAL_SPEED] != 0.0:
            dx, dy = forward - seen[row, rival + _FORWARD], left - seen[row, rival + _LEFT]
            least = min(least, dx * dx + dy * dy)
    return math.sqrt(least) / rules.speed_mps


@rule
def arrival_s(forward: float, left: float, rules: Rules) -> float:
    """`contested_by_time.arrival_s`."""
    return way_s(forward, left, rules) + 0.5 * abs(atan2(left, forward)) / rules.turn_rate_radps


@rule
def way_s(forward: float, left: float, rules: Rules) -> float:
    """Its part without the turn."""
    return max(0.0, math.sqrt(forward * forward + left * left) - rules.reach_m) / rules.speed_mps


@rule
def as_good_as_caught(seen: Seen, row: int, rules: Rules) -> bool:
    """`triage.as_good_as_caught`."""
    if seen[row, rules.first_target + _PRESENT] == 0.0:
        return False
    forward, left = seen[row, rules.first_target + _FORWARD], seen[row, rules.first_target + _LEFT]
    squared = forward * forward + left * left
    return bool(squared < rules.reach_m * rules.reach_m and squared < nearest_rival_m2(seen, row, forward, left, rules))


@rule
def meeting_point(seen: Seen, row: int, target: int, rules: Rules) -> Point:
    """`intercept.meeting_point`."""
    forward = ahead = seen[row, target + _FORWARD]
    left = aside = seen[row, target + _LEFT]
    if rules.targets_move:
        speed = seen[row, target + _TARGET_SPEED]
        for _ in range(rules.looks):
            lead_s = min(rules.longest_lead_s, arrival_s(forward, left, rules))
            forward = ahead + speed * seen[row, target + _TARGET_COS] * lead_s
            left = aside + speed * seen[row, target + _TARGET_SIN] * lead_s
    return forward, left


@rule
def rest(seen: Seen, row: int, rules: Rules) -> Point:
    """`patrol.rest`."""
    forward, left = middle_of_own_ground(seen, row, rules)
    speed, turn = drive(forward, left, rules)
    return min(speed, rules.brake_gain * math.sqrt(forward * forward + left * left) / rules.speed_mps), turn


@rule
def drive(forward: float, left: float, rules: Rules) -> Point:
    """`patrol.drive`."""
    bearing = atan2(left, forward)
    turn = clamp(rules.turn_gain * bearing / rules.turn_rate_radps, -1.0, 1.0)
    if abs(bearing) >= PI / 2:
        return 0.0, turn
    distance = math.sqrt(forward * forward + left * left)
    sine = abs(left) / distance if distance > 0.0 else 0.0
    diameter = (distance + rules.reach_m / 2) / max(1e-6, sine)
    return min(1.0, rules.turn_rate_radps * diameter / 2 / rules.speed_mps), turn


@rule
def middle_of_own_ground(seen: Seen, row: int, rules: Rules) -> Point:
    """`patrol.middle_of_own_ground`."""
    step = (rules.side_m - rules.spawn_low_m - rules.spawn_wall_m) / rules.grid
    cosine, sine = seen[row, _COS], seen[row, _SIN]
    count, ahead, aside = 0, 0.0, 0.0
    for i in range(rules.grid):
        for j in range(rules.grid):
            dx = rules.spawn_low_m + (i + 0.5) * step - seen[row, _X]
            dy = rules.spawn_low_m + (j + 0.5) * step - seen[row, _Y]
            forward, left = cosine * dx + sine * dy, cosine * dy - sine * dx
            if forward * forward + left * left <= nearest_rival_m2(seen, row, forward, left, rules):
                count += 1
                ahead += forward
                aside += left
    return ahead / max(1, count), aside / max(1, count)
