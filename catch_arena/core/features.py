"""Rulebook R7.1, R7.4, R12.4: what is seen of one target, rival or other body, in the order of layout.py's table;
and of the time.
"""

from typing import Any

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
from catch_arena.layout import (
    BodyFeatures,
    MotionFeatures,
    MovingTargetFeatures,
    RivalFeatures,
    TargetFeatures,
    TeamFeatures,
    TeamRivalFeatures,
)


@rule
def in_frame_of(me: Block, x: float, y: float, lane: int) -> tuple[float, float]:
    """R7.1: how far ahead of an observer a place is, and how far to its left [m].

    Args:
        me: the rows of the observer's body.
        x: in the world frame [m].
        y: the same.
        lane: the lane.
    """
    sine, cosine = me[SINE + lane], me[COSINE + lane]
    dx, dy = x - me[X + lane], y - me[Y + lane]
    return cosine * dx + sine * dy, cosine * dy - sine * dx


@rule
def heading_in_frame_of(me: Block, sine: float, cosine: float, lane: int) -> tuple[float, float]:
    """R7.1: cosine and sine of a heading relative to an observer's.

    Args:
        me: the rows of the observer's body.
        sine: of the heading.
        cosine: of the heading.
        lane: the lane.
    """
    my_sine, my_cosine = me[SINE + lane], me[COSINE + lane]
    return cosine * my_cosine + sine * my_sine, sine * my_cosine - cosine * my_sine


@rule
def body_at(me: Block, other: Block, lane: int) -> BodyFeatures:
    """R12.4: what one body sees of another; both begin with the rows of a body.

    Args:
        me: the rows of the observer.
        other: the rows of the body that it sees.
        lane: the lane.
    """
    forward, left = in_frame_of(me, other[X + lane], other[Y + lane], lane)
    heading_cos, heading_sin = heading_in_frame_of(me, other[SINE + lane], other[COSINE + lane], lane)
    return BodyFeatures(
        forward=forward,
        left=left,
        present=1.0,
        heading_cos=heading_cos,
        heading_sin=heading_sin,
        linear_velocity=other[SPEED + lane],
    )


@rule
def rival_at(block: Block, seat: int, other: int, lane: int, teams: NDArray[np.int64]) -> Any:
    """R7.1, R7.4: what one seat sees of another hunter, a `layout.TeamRivalFeatures`.

    Args:
        block: the block.
        seat: who sees.
        other: the seat that is seen.
        lane: the lane.
        teams: see `memory.Sections`.
    """
    me, rival = seat_of(block, seat), seat_of(block, other)
    forward, left = in_frame_of(me, rival[X + lane], rival[Y + lane], lane)
    heading_cos, heading_sin = heading_in_frame_of(me, rival[SINE + lane], rival[COSINE + lane], lane)
    seen = RivalFeatures(
        forward=forward,
        left=left,
        present=1.0,
        heading_cos=heading_cos,
        heading_sin=heading_sin,
        linear_velocity=rival[SPEED + lane],
        score_difference=rival[SCORE + lane] - me[SCORE + lane],
    )
    in_teams = TeamFeatures(mate=1.0 if teams[seat] == teams[other] else 0.0)
    return TeamRivalFeatures(*seen[:], *in_teams[:])  # Numba unpacks plain tuples only


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
    forward, left = in_frame_of(me, targets[TARGET_X + at], targets[TARGET_Y + at], lane)
    return TargetFeatures(
        forward=forward,
        left=left,
        present=1.0,
        age=age,
        active=select(targets[NUMBER + at] == me[ACTIVE + lane], 1.0, 0.0),
    )


@rule
def moving_target_at(me: Block, targets: Block, at: int, lane: int, age: float) -> Any:
    """R7.4: the same where targets move, a `layout.MovingTargetFeatures`; arguments as of `target_at`."""
    heading_cos, heading_sin = heading_in_frame_of(me, targets[BODY + SINE + at], targets[BODY + COSINE + at], lane)
    motion = MotionFeatures(
        heading_cos=heading_cos, heading_sin=heading_sin, linear_velocity=targets[BODY + SPEED + at]
    )
    seen = target_at(me, targets, at, lane, age)
    return MovingTargetFeatures(*seen[:], *motion[:])  # Numba unpacks plain tuples only
