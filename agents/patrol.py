"""Drives itself: flat out to a race, or to good ground."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from catch_arena.agents.contested_by_time import best_race
from catch_arena.batch_policy import BatchView
from catch_arena.policy import Limits, View

Numbers = NDArray[np.float64]

GRID = 5
"""The spawn area is looked at in GRID x GRID points."""
SPAWN_LOW_M, SPAWN_WALL_M = 0.5, 0.5889
"""R3.2: spawns keep these distances from the walls at 0 and from those opposite."""
TURN_GAIN = 6.0
"""Turn rate per radian of bearing [1/s]."""
BRAKE_GAIN = 2.0
"""Speed per metre that is left to a resting place [1/s]."""


class Agent:
    """Catches as it drives by: under velocity control what is within reach is requested for it (R4.4)."""

    control = "velocity"

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: View) -> tuple[float, float]:
        """Speed and turn rate as parts of the limits, in [-1, 1]."""
        target = best_race(view)
        if target is not None:
            return drive(target.forward, target.left, view)
        forward, left = middle_of_own_ground(view)
        speed, turn = drive(forward, left, view)
        return min(speed, BRAKE_GAIN * math.hypot(forward, left) / view.limits.max_speed_mps), turn

    def act_batch(self, view: BatchView) -> Numbers:
        """The same for N hunters: (N, 2)."""
        forward, left, racing = best_races(view)
        actions = drive_all(forward, left, view.limits)
        idle = np.flatnonzero(~racing)
        if len(idle):
            forward, left = middles_of_own_ground(view.of(idle))
            actions[idle] = drive_all(forward, left, view.limits)
            resting = BRAKE_GAIN * np.hypot(forward, left) / view.limits.max_speed_mps
            actions[idle, 0] = np.minimum(actions[idle, 0], resting)
        return actions


def drive(forward: float, left: float, view: View) -> tuple[float, float]:
    """The command that brings a point of the own frame [m] within reach, as fast as the arc to it allows."""
    limits = view.limits
    bearing = math.atan2(left, forward)
    turn = max(-1.0, min(1.0, TURN_GAIN * bearing / limits.max_turn_rate_radps))
    if abs(bearing) >= math.pi / 2:
        return 0.0, turn  # driving would only lead away
    # the circle that is tangent to the heading and passes half a reach from the point has a diameter of:
    diameter = (math.hypot(forward, left) + limits.reach_m / 2) / max(1e-6, abs(math.sin(bearing)))
    return min(1.0, limits.max_turn_rate_radps * diameter / 2 / limits.max_speed_mps), turn


def middle_of_own_ground(view: View) -> tuple[float, float]:
    """The mean (forward, left) [m] of those points of the spawn area that no rival is nearer to."""
    step = (view.limits.side_m - SPAWN_LOW_M - SPAWN_WALL_M) / GRID
    places = [SPAWN_LOW_M + (i + 0.5) * step for i in range(GRID)]
    rivals = [(rival.forward, rival.left) for rival in view.rivals]
    own = [
        (forward, left)
        for forward, left in (view.to_own_frame(x, y) for x in places for y in places)
        if all(math.hypot(forward, left) <= math.hypot(forward - ahead, left - aside) for ahead, aside in rivals)
    ]
    if not own:
        return 0.0, 0.0
    return sum(forward for forward, _ in own) / len(own), sum(left for _, left in own) / len(own)


# the same for N hunters at once, in arrays: (N,), with targets (N, K), with rivals too (N, K, R)


def best_races(view: BatchView) -> tuple[Numbers, Numbers, NDArray[np.bool_]]:
    """`contested_by_time.best_race`: forward and left of that target [m], and where there is one."""
    targets, rivals, limits = view.targets, view.rivals, view.limits
    ahead, aside = (np.asarray(column, dtype=np.float64) for column in (targets.forward, targets.left))
    present = targets.present > 0
    mine = np.where(present, arrivals_s(ahead, aside, limits), np.inf)
    theirs = np.full(mine.shape, np.inf)
    for rank in range(limits.hunters_seen):
        column = {name: np.asarray(values[:, rank], np.float64)[:, None] for name, values in rivals._asdict().items()}
        dx, dy = ahead - column["forward"], aside - column["left"]
        cosine, sine = column["heading_cos"], column["heading_sin"]
        arrival = arrivals_s(cosine * dx + sine * dy, cosine * dy - sine * dx, limits)
        moving = column["linear_velocity"] != 0  # who stands still races for nothing, and who is absent does too
        np.minimum(theirs, arrival, out=theirs, where=moving)
    late = np.where(present, mine, 0.0) - theirs
    won = present & (late <= 0.0)
    some_won = won.any(axis=1)
    choice = np.where(
        some_won, np.argmin(np.where(won, mine, np.inf), 1), np.argmin(np.where(present, late, np.inf), 1)
    )
    rows = np.arange(len(choice))
    return ahead[rows, choice], aside[rows, choice], present[:, 0]


def arrivals_s(forward: Numbers, left: Numbers, limits: Limits) -> Numbers:
    """`contested_by_time.arrival_s`."""
    way = np.maximum(0.0, np.hypot(forward, left) - limits.reach_m)
    turn: Any = np.abs(np.arctan2(left, forward))
    return way / limits.max_speed_mps + 0.5 * turn / limits.max_turn_rate_radps


def drive_all(forward: Numbers, left: Numbers, limits: Limits) -> Numbers:
    """`drive`: (N, 2)."""
    bearing = np.arctan2(left, forward)
    turn = np.clip(TURN_GAIN * bearing / limits.max_turn_rate_radps, -1.0, 1.0)
    diameter = (np.hypot(forward, left) + limits.reach_m / 2) / np.maximum(1e-6, np.abs(np.sin(bearing)))
    speed = np.minimum(1.0, limits.max_turn_rate_radps * diameter / 2 / limits.max_speed_mps)
    return np.stack((np.where(np.abs(bearing) >= math.pi / 2, 0.0, speed), turn), axis=1)


def middles_of_own_ground(view: BatchView) -> tuple[Numbers, Numbers]:
    """`middle_of_own_ground`: forward and left [m]."""
    own, rivals = view.own, view.rivals
    step = (view.limits.side_m - SPAWN_LOW_M - SPAWN_WALL_M) / GRID
    places = SPAWN_LOW_M + (np.arange(GRID) + 0.5) * step
    x, y, cosine, sine = (np.asarray(c, np.float64)[:, None] for c in (own.x, own.y, own.heading_cos, own.heading_sin))
    dx, dy = np.repeat(places, GRID) - x, np.tile(places, GRID) - y
    forward, left = cosine * dx + sine * dy, cosine * dy - sine * dx
    mine = np.ones(forward.shape, dtype=np.bool_)
    for rank in range(view.limits.hunters_seen):
        ahead, aside = (np.asarray(c[:, rank], np.float64)[:, None] for c in (rivals.forward, rivals.left))
        nearer = np.hypot(forward, left) <= np.hypot(forward - ahead, left - aside)
        mine &= nearer | (rivals.present[:, rank] == 0)[:, None]
    count = np.maximum(1, mine.sum(axis=1))
    return (forward * mine).sum(axis=1) / count, (left * mine).sum(axis=1) / count
