"""Rulebook chapter 4: from an action to a velocity command and a catch request. All of it reads S_t only."""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.arbiter import NO_SUCH_RANK, distance_um, within_reach
from catch_arena.core.jit import Block, phase, rule
from catch_arena.core.math import atan2, clamp, wrap
from catch_arena.core.state import (
    ACTIVE,
    ALIVE,
    BEARING_INTEGRAL,
    COSINE,
    DISTANCE_INTEGRAL,
    LANES,
    NO_TARGET,
    SINE,
    SPEED,
    TURN_RATE,
    WANTED,
    WITHDRAWN,
    Settings,
    Targets,
    X,
    Y,
    item_at,
)


@rule
def pi_step(
    error: float, integral: float, kp: float, ki: float, low: float, high: float, dt: float
) -> tuple[float, float]:
    """R4.3: one step of a PI loop: its limited output, and the integral to go on with, which does not grow while the
    output saturates.
    """
    grown = integral + error * dt
    output = kp * error + ki * grown
    saturated = ((output > high) & (error > 0.0)) | ((output < low) & (error < 0.0))
    return clamp(output, low, high), integral if saturated else grown


@phase
def choose(arena: Block, me: Block, view: Block, ranks: NDArray[np.int64], lanes: int, s: Settings) -> None:
    """R4.1: the slots that belong to the ranks chosen, NO_TARGET for hold and NO_SUCH_RANK for a rank without a
    target.
    """
    for lane in range(lanes):
        rank = ranks[lane]
        wanted = NO_TARGET
        if rank > min(int(arena[ALIVE + lane]), s.targets_seen):
            wanted = NO_SUCH_RANK
        elif rank > 0:
            wanted = item_at(view, rank - 1, lane)
        me[WANTED + lane] = wanted


@phase
def set_goal(me: Block, targets: Targets, lanes: int, goal: Block) -> None:
    """R4.1: where the target is to which each lane drives, dx and dy, and its number; 0 for hold.

    Fetched here, one by one, so that the loop that computes with them can be SIMD code.
    """
    for lane in range(lanes):
        holds = (me[WANTED + lane] < 0.0) | (me[WITHDRAWN + lane] > 0.0)
        slot = np.uint64(max(me[WANTED + lane], 0.0)) * np.uint64(LANES) + np.uint64(lane)
        goal[lane] = targets.x[slot]
        goal[LANES + lane] = targets.y[slot]
        goal[2 * LANES + lane] = 0.0 if holds else targets.number[slot]


@phase
def drive_to_goal(me: Block, goal: Block, lanes: int, s: Settings) -> None:
    """R4.1, R4.2, R4.3: the hosted controllers; a target out of reach is driven to, but not yet requested."""
    for lane in range(lanes):
        dx = goal[lane] - me[X + lane]
        dy = goal[LANES + lane] - me[Y + lane]
        number = goal[2 * LANES + lane]
        holds = number == 0.0
        sine = me[SINE + lane]
        cosine = me[COSINE + lane]
        fresh = holds | (number != me[ACTIVE + lane])
        speed, distance_integral = pi_step(
            sqrt(dx * dx + dy * dy),
            0.0 if fresh else me[DISTANCE_INTEGRAL + lane],
            s.kp_v,
            s.ki_v,
            s.min_speed,
            s.max_speed,
            s.period_s,
        )
        turn_rate, bearing_integral = pi_step(
            wrap(atan2(cosine * dy - sine * dx, cosine * dx + sine * dy)),
            0.0 if fresh else me[BEARING_INTEGRAL + lane],
            s.kp_w,
            s.ki_w,
            -s.max_turn_rate,
            s.max_turn_rate,
            s.period_s,
        )
        me[SPEED + lane] = 0.0 if holds else speed
        me[TURN_RATE + lane] = 0.0 if holds else turn_rate
        me[DISTANCE_INTEGRAL + lane] = 0.0 if holds else distance_integral
        me[BEARING_INTEGRAL + lane] = 0.0 if holds else bearing_integral
        me[ACTIVE + lane] = number
        near = within_reach(distance_um(dx, dy), s.reach_um)
        me[WANTED + lane] = me[WANTED + lane] if near | (me[WANTED + lane] < 0.0) else float(NO_TARGET)


@phase
def request_nearest(arena: Block, me: Block, view: Block, targets: Targets, lanes: int, s: Settings) -> None:
    """R4.4: under velocity control the nearest target is requested whenever it is within reach."""
    for lane in range(lanes):
        me[WANTED + lane] = NO_TARGET
        if arena[ALIVE + lane] > 0.0:
            slot = item_at(view, 0, lane)
            at = slot * LANES + lane
            if within_reach(distance_um(targets.x[at] - me[X + lane], targets.y[at] - me[Y + lane]), s.reach_um):
                me[WANTED + lane] = slot


@phase
def mark_active(me: Block, targets: Targets, lanes: int) -> None:
    """R4.4: under full control the target requested is the active one, for this step."""
    for lane in range(lanes):
        active = 0.0
        if me[WANTED + lane] >= 0.0 and me[WITHDRAWN + lane] == 0.0:
            active = targets.number[int(me[WANTED + lane]) * LANES + lane]
        me[ACTIVE + lane] = active


@phase
def drive_by_command(me: Block, commands: NDArray[np.float32], lanes: int, s: Settings) -> None:
    """R2.5, R4.4: velocities as fractions of the limits; a request for a rank without a target makes the hunter hold
    (R5.2).
    """
    for lane in range(lanes):
        holds = (me[WANTED + lane] == float(NO_SUCH_RANK)) | (me[WITHDRAWN + lane] > 0.0)
        speed = clamp(np.float64(commands[lane, 0]) * s.max_speed, s.min_speed, s.max_speed)
        turn_rate = clamp(np.float64(commands[lane, 1]) * s.max_turn_rate, -s.max_turn_rate, s.max_turn_rate)
        me[SPEED + lane] = 0.0 if holds else speed
        me[TURN_RATE + lane] = 0.0 if holds else turn_rate
