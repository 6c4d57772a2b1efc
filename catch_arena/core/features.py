"""Rulebook R7.1, R7.4, R12.4: what is seen of one target, rival or other body, in the order of layout.py's table;
and of the time.
"""

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.jit import Block, rule
from catch_arena.core.state import (
    ACTIVE,
    BODY,
    COSINE,
    NUMBER,
    SCORE,
    SINE,
    SPEED,
    TARGET_X,
    TARGET_Y,
    TIME,
    Settings,
    X,
    Y,
    seat_of,
)
from catch_arena.core.vectors import select
from catch_arena.layout import BodyFeatures, MovingTargetFeatures, TargetFeatures, TeamRivalFeatures


@rule
def body_at(me: Block, other: Block, lane: int) -> BodyFeatures:
    """R7.1, R12.4: what one body sees of another; both begin with the rows of a body.

    Args:
        me: the rows of the observer.
        other: the rows of the body that it sees.
        lane: the lane.
    """
    sine, cosine = me[SINE + lane], me[COSINE + lane]
    other_sine, other_cosine = other[SINE + lane], other[COSINE + lane]
    dx, dy = other[X + lane] - me[X + lane], other[Y + lane] - me[Y + lane]
    return BodyFeatures(
        forward=cosine * dx + sine * dy,
        left=cosine * dy - sine * dx,
        present=1.0,
        heading_cos=other_cosine * cosine + other_sine * sine,
        heading_sin=other_sine * cosine - other_cosine * sine,
        linear_velocity=other[SPEED + lane],
    )


@rule
def rival_at(block: Block, seat: int, other: int, lane: int, teams: NDArray[np.int64]) -> TeamRivalFeatures:
    """R7.1, R7.4: what one seat sees of another hunter.

    Args:
        block: the block.
        seat: who sees.
        other: the seat that is seen.
        lane: the lane.
        teams: see `memory.Sections`.
    """
    me, rival = seat_of(block, seat), seat_of(block, other)
    body = body_at(me, rival, lane)[:]  # Numba unpacks plain tuples only
    mate = 1.0 if teams[seat] == teams[other] else 0.0
    return TeamRivalFeatures(*body, rival[SCORE + lane] - me[SCORE + lane], mate)


@rule
def time_left_at(block: Block, s: Settings, lane: int) -> float:
    """R7.1, R12.4: until the time limit [s].

    Args:
        block: the block, for its row TIME [ms].
        s: the settings.
        lane: the lane.
    """
    remaining = s.time_limit_ms - block[TIME + lane]
    seconds: float = select(remaining > 0.0, remaining / 1000.0, 0.0)
    return seconds


@rule
def target_at(me: Block, targets: Block, at: int, lane: int, age: float) -> TargetFeatures:
    """R7.1: what a seat sees of the target at `at`, which is that old [s].

    Args:
        me: the rows of the seat.
        targets: the slots of the block.
        at: where in `targets` the slot begins, its lane or group of lanes included.
        lane: the lane.
        age: of the target [s].
    """
    sine, cosine = me[SINE + lane], me[COSINE + lane]
    dx, dy = targets[TARGET_X + at] - me[X + lane], targets[TARGET_Y + at] - me[Y + lane]
    return TargetFeatures(
        forward=cosine * dx + sine * dy,
        left=cosine * dy - sine * dx,
        present=1.0,
        age=age,
        active=select(targets[NUMBER + at] == me[ACTIVE + lane], 1.0, 0.0),
    )


@rule
def moving_target_at(me: Block, targets: Block, at: int, lane: int, age: float) -> MovingTargetFeatures:
    """R7.4: the same where targets move; arguments as of `target_at`."""
    sine, cosine = me[SINE + lane], me[COSINE + lane]
    target_sine, target_cosine = targets[BODY + SINE + at], targets[BODY + COSINE + at]
    heading_cos = target_cosine * cosine + target_sine * sine
    heading_sin = target_sine * cosine - target_cosine * sine
    still = target_at(me, targets, at, lane, age)[:]  # Numba unpacks plain tuples only
    return MovingTargetFeatures(*still, heading_cos, heading_sin, targets[BODY + SPEED + at])
