"""Rulebook chapter 4: velocity commands and catch requests from actions. All functions read S_t only."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core import rows
from catch_arena.core.arbiter import measure_um, to_micrometres, within_reach
from catch_arena.core.jit import Rows, outlined, phase, rule
from catch_arena.core.math import atan2, below_pi, clamp
from catch_arena.core.memory import Sections
from catch_arena.core.state import (
    ABSENT,
    Order,
    Orders,
    SeatLimits,
    Settings,
    item_at_rank,
    limits_of,
    seat_of,
    targets_of,
)
from catch_arena.core.vectors import LANES, SINGLE, Width, group, played_lanes, select, sqrt

TARGET_CONTROL: Final = 0
VELOCITY_CONTROL: Final = 1
FULL_CONTROL: Final = 2

# rows of the active target of each lane
ACTIVE_X: Final = 0 * LANES  # its position [m], 0 to the arena's side
ACTIVE_Y: Final = 1 * LANES  # as ACTIVE_X
ACTIVE_NUMBER: Final = 2 * LANES  # its spawn number, from 1; 0 for none

CONTROLS: Final = {"target": TARGET_CONTROL, "velocity": VELOCITY_CONTROL, "full": FULL_CONTROL}


@rule
def pi_step(
    error: float, integral: float, kp: float, ki: float, low: float, high: float, dt: float
) -> tuple[float, float]:
    """R4.3: return the limited output of one step of a PI loop, and its new integral, which does not grow while the
    output saturates. For an error in [m] or [rad], the integral is in [m s] or [rad s], the gains `kp` [1/s] and `ki`
    [1/s^2], and the limits of the output, `low` and `high`, in [m/s] or [rad/s]; `dt` is the control period [s].
    """
    grown = integral + error * dt
    output = kp * error + ki * grown
    saturated = ((output > high) & (error > 0.0)) | ((output < low) & (error < 0.0))
    return clamp(output, low, high), select(saturated, integral, grown)


@phase
def look_up_choices(
    me: Rows,
    s: Settings,
    lanes: int,
    seat: int,
    order: Order,
    targets: Rows,
    choices: NDArray[np.int64],
    requested: Rows,
    active_targets: Rows,
) -> None:
    """R4.1, R5.2's MALFORMED: look up the target of each lane's choice, lane by lane, since targets are in any slot.

    Args:
        requested: the result, one row: the target's slot, NO_TARGET for hold, MALFORMED_REQUEST for a rank without a
            target.
        active_targets: the result, the rows ACTIVE_X, ACTIVE_Y [m] and ACTIVE_NUMBER of the target; its number is 0
            without a target: on hold, for a rank that has none, and if the hunter is withdrawn.
    """
    for lane in range(lanes):
        rank = choices[lane, seat]
        shown = (rank > 0) & (rank <= s.targets_seen)
        slot = item_at_rank(order, select(shown, rank - 1, 0), lane)
        seen = shown & (slot != ABSENT)
        at = select(seen, slot, 0) * s.slot_size + lane
        unseen = select(rank > 0, float(rows.MALFORMED_REQUEST), float(rows.NO_TARGET))
        requested[lane] = select(seen, float(slot), unseen)
        active_targets[ACTIVE_X + lane] = targets[rows.TARGET_X + at]
        active_targets[ACTIVE_Y + lane] = targets[rows.TARGET_Y + at]
        active_targets[ACTIVE_NUMBER + lane] = select(
            seen & (me[rows.WITHDRAWN + lane] == 0.0), targets[rows.NUMBER + at], 0.0
        )


@phase
def drive_to_target(
    me: Rows, s: Settings, width: Width, active_targets: Rows, limits: SeatLimits, requested: Rows
) -> None:
    """R4.1, R4.2, R4.3: drive to active targets by hosted controllers, and drop requests for targets out of reach."""
    for first in range(0, played_lanes(width), len(width)):
        lane = group(first, width)
        dx = active_targets[ACTIVE_X + lane] - me[rows.X + lane]
        dy = active_targets[ACTIVE_Y + lane] - me[rows.Y + lane]
        number = active_targets[ACTIVE_NUMBER + lane]
        holds = number == 0.0
        fresh = holds | (number != me[rows.ACTIVE + lane])
        sine, cosine = me[rows.SINE + lane], me[rows.COSINE + lane]
        distance = sqrt(dx * dx + dy * dy)
        speed, distance_integral = pi_step(
            distance,
            select(fresh, 0.0, me[rows.DISTANCE_INTEGRAL + lane]),
            s.kp_v,
            s.ki_v,
            limits.min_speed,
            limits.max_speed,
            s.period_s,
        )
        turn_rate, bearing_integral = pi_step(
            below_pi(atan2(cosine * dy - sine * dx, cosine * dx + sine * dy)),
            select(fresh, 0.0, me[rows.BEARING_INTEGRAL + lane]),
            s.kp_w,
            s.ki_w,
            -limits.max_turn_rate,
            limits.max_turn_rate,
            s.period_s,
        )
        me[rows.SPEED + lane] = select(holds, 0.0, speed)
        me[rows.TURN_RATE + lane] = select(holds, 0.0, turn_rate)
        me[rows.DISTANCE_INTEGRAL + lane] = select(holds, 0.0, distance_integral)
        me[rows.BEARING_INTEGRAL + lane] = select(holds, 0.0, bearing_integral)
        me[rows.ACTIVE + lane] = number
        near = within_reach(to_micrometres(distance), limits.reach_um)
        without_target = requested[lane] < 0.0
        requested[lane] = select(near | without_target, requested[lane], float(rows.NO_TARGET))


@phase
def request_nearest(
    me: Rows, s: Settings, lanes: int, order: Order, targets: Rows, limits: SeatLimits, requested: Rows
) -> None:
    """R4.4: request the nearest target whenever it is within reach, under velocity control."""
    for lane in range(lanes):
        requested[lane] = rows.NO_TARGET
        slot = item_at_rank(order, 0, lane)
        if slot != ABSENT:
            at = slot * s.slot_size + lane
            distance_um = measure_um(
                targets[rows.TARGET_X + at] - me[rows.X + lane], targets[rows.TARGET_Y + at] - me[rows.Y + lane]
            )
            if within_reach(distance_um, limits.reach_um):
                requested[lane] = slot


@phase
def drive_by_command(
    me: Rows, seat: int, commands: NDArray[np.float32], width: Width, lanes: int, limits: SeatLimits, requested: Rows
) -> None:
    """R2.5, R4.4: set velocities from fractions of the limits; a hunter whose request names a rank without a target
    holds (R5.2).
    """
    for lane in range(lanes):
        me[rows.SPEED + lane] = np.float64(commands[lane, seat, 0]) * limits.max_speed
        me[rows.TURN_RATE + lane] = np.float64(commands[lane, seat, 1]) * limits.max_turn_rate
    for first in range(0, played_lanes(width), len(width)):
        lane = group(first, width)
        holds = (requested[lane] == float(rows.MALFORMED_REQUEST)) | (me[rows.WITHDRAWN + lane] > 0.0)
        speed = clamp(me[rows.SPEED + lane], limits.min_speed, limits.max_speed)
        turn_rate = clamp(me[rows.TURN_RATE + lane], -limits.max_turn_rate, limits.max_turn_rate)
        me[rows.SPEED + lane] = select(holds, 0.0, speed)
        me[rows.TURN_RATE + lane] = select(holds, 0.0, turn_rate)


@phase
def steer_seat(
    me: Rows,
    s: Settings,
    width: Width,
    lanes: int,
    seat: int,
    order: Order,
    targets: Rows,
    control: int,
    choices: NDArray[np.int64],
    commands: NDArray[np.float32],
    limits: SeatLimits,
    requested: Rows,
    active_targets: Rows,
) -> None:
    """R4.1, R4.4: steer one seat by one control, in all lanes."""
    if control == TARGET_CONTROL:
        look_up_choices(me, s, lanes, seat, order, targets, choices, requested, active_targets)
        drive_to_target(me, s, width, active_targets, limits, requested)
    elif control == VELOCITY_CONTROL:
        request_nearest(me, s, lanes, order, targets, limits, requested)
        drive_by_command(me, seat, commands, width, lanes, limits, requested)
    else:
        look_up_choices(me, s, lanes, seat, order, targets, choices, requested, active_targets)
        for first in range(0, played_lanes(width), len(width)):  # R4.4: the requested target is active in this step
            lane = group(first, width)
            me[rows.ACTIVE + lane] = active_targets[ACTIVE_NUMBER + lane]
        drive_by_command(me, seat, commands, width, lanes, limits, requested)


@outlined
def steer_lane_by_lane(
    me: Rows,
    s: Settings,
    seat: int,
    order: Order,
    targets: Rows,
    controls: NDArray[np.int8],
    choices: NDArray[np.int64],
    commands: NDArray[np.float32],
    limits: SeatLimits,
    requested: Rows,
    active_targets: Rows,
) -> None:
    """Steer one seat whose control differs by arena: each lane as an arena of its own."""
    for lane in range(len(controls)):
        steer_seat(
            me[lane:],
            s,
            SINGLE,
            1,
            seat,
            order[lane:],
            targets[lane:],
            controls[lane, seat],
            choices[lane:],
            commands[lane:],
            limits,
            requested[lane:],
            active_targets,
        )


@phase
def controls_differ(controls: NDArray[np.int8], seat: int) -> bool:
    """Return whether a seat's control differs by arena."""
    found = False
    for lane in range(1, len(controls)):
        found |= controls[lane, seat] != controls[0, seat]
    return found


@phase
def apply_actions(
    chunk: Rows,
    s: Settings,
    width: Width,
    lanes: int,
    orders: Orders,
    controls: NDArray[np.int8],
    choices: NDArray[np.int64],
    commands: NDArray[np.float32],
    sections: Sections,
) -> None:
    """R1.4's phases 1 and 2: turn actions into velocities and requested slots, on S_t."""
    targets, active_targets = targets_of(chunk, s), sections.scratch_rows
    for seat in range(s.hunters):
        me = seat_of(chunk, seat)
        order = orders[seat]
        own, requested = limits_of(sections.limits, seat), sections.requested_slots[seat]
        if s.any_control and controls_differ(controls, seat):
            steer_lane_by_lane(me, s, seat, order, targets, controls, choices, commands, own, requested, active_targets)
        else:
            control = controls[0, seat]
            steer_seat(
                me, s, width, lanes, seat, order, targets, control, choices, commands, own, requested, active_targets
            )
