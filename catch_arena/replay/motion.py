"""Poses of hunters and targets at any instant: a step's ticks, computed again, and straight lines between them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from catch_arena.core.math import sincos
from catch_arena.core.physics import DT, TICK_MS, WATCHDOG_MS, next_pose, turned
from catch_arena.world import HunterState, TargetState, World

Pose2D = tuple[float, float, float]
"""Pose x [m], y [m], theta [rad], as in geometry_msgs; `messages.Pose` is turtlesim's, with velocities."""


class Poses(NamedTuple):
    """Poses of all hunters and targets at one instant."""

    hunters: tuple[Pose2D, ...]
    """Poses of the hunters, by seat."""
    targets: Mapping[int, Pose2D]
    """Poses of the targets that are not caught in this step, by number."""


@dataclass(frozen=True, slots=True)
class StepMotion:
    """Motion in one step.

    The scores, rulings and targets of `after` hold from the beginning of the step: R1.4 judges and commits before the
    turtles move.
    """

    before: World
    after: World
    poses: tuple[Poses, ...]
    """Poses at each tick, first those at the beginning of the step. Nothing moves after the last one."""

    def at(self, time_ms: float, next_tick: Poses | None = None) -> Poses:
        """Return the poses at an instant of this step [ms since reset], interpolated between two ticks.

        After the last tick they lead to `next_tick`, the poses at the first tick after this step; None keeps the last.
        """
        tick = math.floor(time_ms / TICK_MS)
        index = tick - self.before.time_ms // TICK_MS
        if index + 1 < len(self.poses):
            start, end = self.poses[index], self.poses[index + 1]
        elif next_tick is not None and tick >= self.after.time_ms // TICK_MS:
            start, end = self.poses[-1], next_tick
        else:
            return self.poses[-1]
        part = time_ms / TICK_MS - tick
        return Poses(
            tuple(interpolate(a, b, part) for a, b in zip(start.hunters, end.hunters, strict=True)),
            # a target that is caught in the next step does not move in it
            {number: interpolate(pose, end.targets.get(number, pose), part) for number, pose in start.targets.items()},
        )

    def ticks_between(self, after_ms: float, until_ms: float) -> list[Poses]:
        """Return the poses at this step's ticks in (after_ms, until_ms]."""
        first = self.before.time_ms // TICK_MS
        return [
            poses for tick, poses in enumerate(self.poses[1:], start=first + 1) if after_ms < tick * TICK_MS <= until_ms
        ]


def poses_of(world: World) -> Poses:
    """Return the poses of a world, at a step's boundary."""
    return Poses(
        tuple((hunter.x, hunter.y, hunter.theta) for hunter in world.hunters),
        {target.number: (target.x, target.y, target.theta) for target in world.targets},
    )


def interpolate(start: Pose2D, end: Pose2D, part: float) -> Pose2D:
    """Return the pose at a fraction `part` of the straight way, with the shorter turn."""
    if start is end:  # the case for most still targets
        return start
    turn = (end[2] - start[2] + math.pi) % (2.0 * math.pi) - math.pi
    return (
        start[0] + (end[0] - start[0]) * part,
        start[1] + (end[1] - start[1]) * part,
        start[2] + turn * part,
    )


def step_motion(before: World, after: World) -> StepMotion:
    """Return a step's motion, from the poses of the world before it and the velocities of the world after it."""
    first = before.time_ms // TICK_MS
    driven = min(after.time_ms, before.time_ms + WATCHDOG_MS) // TICK_MS - first  # R2.4: after it hunters stand still
    moved = any(target.linear_velocity or target.angular_velocity for target in after.targets)
    ticks = min(after.time_ms // TICK_MS - first, 10_000 // TICK_MS) if moved else driven
    began = {target.number: target for target in before.targets}
    hunters = [
        _body_ticks(start, end, driven, after.side_m) for start, end in zip(before.hunters, after.hunters, strict=True)
    ]
    targets = {end.number: _body_ticks(began.get(end.number, end), end, ticks, after.side_m) for end in after.targets}
    poses = tuple(
        Poses(
            tuple(track[min(tick, driven)] for track in hunters),
            {number: track[tick] for number, track in targets.items()},
        )
        for tick in range(ticks + 1)
    )
    return StepMotion(before, after, poses)


def _body_ticks(
    start: HunterState | TargetState, end: HunterState | TargetState, ticks: int, side_m: float
) -> list[Pose2D]:
    """Return a body's poses at the beginning of a step and at each tick."""
    x, y = start.x, start.y
    poses = [(x, y, start.theta)]
    if start.theta == end.theta and (x, y) == (end.x, end.y):  # the case for most targets
        return poses * (ticks + 1)
    stride, turn = end.linear_velocity * DT, end.angular_velocity * DT
    sine, cosine = sincos(start.theta)
    turn_sine, turn_cosine = sincos(turn)
    for tick in range(1, ticks + 1):
        x, y, sine, cosine, _ = next_pose(x, y, sine, cosine, stride, turn_sine, turn_cosine, side_m)
        poses.append((x, y, turned(start.theta, turn, tick)))
    if math.hypot(x - end.x, y - end.y) > 1e-6:
        # in steps of more than a second the watchdog has reset the velocity, and in steps of more than ten seconds
        # targets are not followed: only a straight line can be drawn
        goal = (end.x, end.y, end.theta)
        poses = [interpolate(poses[0], goal, tick / max(1, ticks)) for tick in range(ticks + 1)]
    return poses
