"""Rulebook R7.1, R7.4, R12.4: what is seen of one target, rival or other body, in the order of layout.py's table;
and of the time.
"""

from typing import Any

from catch_arena.core.jit import Block, rule
from catch_arena.core.state import (
    ACTIVE,
    COSINE,
    SCORE,
    SINE,
    TIME,
    Settings,
    X,
    Y,
)
from catch_arena.core.tiles import BodyTile, MotionTile, TargetTile, body_tile
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
def body_seen(me: Block, body: BodyTile, lane: int) -> BodyFeatures:
    """R12.4: what one body sees of another.

    Args:
        me: the rows of the observer.
        body: the body that it sees.
        lane: the lane.
    """
    forward, left = in_frame_of(me, body.x, body.y, lane)
    heading_cos, heading_sin = heading_in_frame_of(me, body.sine, body.cosine, lane)
    return BodyFeatures(
        forward=forward,
        left=left,
        present=1.0,
        heading_cos=heading_cos,
        heading_sin=heading_sin,
        linear_velocity=body.speed,
    )


@rule
def body_at(me: Block, other: Block, lane: int) -> BodyFeatures:
    """R12.4: the same of a body's rows."""
    return body_seen(me, body_tile(other, 0.0, lane), lane)


@rule
def rival_seen(me: Block, rival: BodyTile, lane: int) -> RivalFeatures:
    """R7.1: what one hunter sees of another; arguments as of `body_seen`."""
    body = body_seen(me, rival, lane)
    return RivalFeatures(
        forward=body.forward,
        left=body.left,
        present=body.present,
        heading_cos=body.heading_cos,
        heading_sin=body.heading_sin,
        linear_velocity=body.linear_velocity,
        score_difference=rival.score - me[SCORE + lane],
    )


@rule
def team_rival_seen(me: Block, rival: BodyTile, team: float, lane: int) -> Any:
    """R7.4: the same where there are teams, a `layout.TeamRivalFeatures`; `team`, the observer's own."""
    seen, in_teams = rival_seen(me, rival, lane), TeamFeatures(mate=select(rival.team == team, 1.0, 0.0))
    return TeamRivalFeatures(*seen[:], *in_teams[:])  # Numba unpacks plain tuples only


@rule
def target_seen(me: Block, target: TargetTile, lane: int) -> TargetFeatures:
    """R7.1: what a hunter sees of a target.

    Args:
        me: the rows of the hunter.
        target: the target.
        lane: the lane.
    """
    forward, left = in_frame_of(me, target.x, target.y, lane)
    return TargetFeatures(
        forward=forward,
        left=left,
        present=1.0,
        age=target.age,
        active=select(target.number == me[ACTIVE + lane], 1.0, 0.0),
    )


@rule
def moving_target_seen(me: Block, target: TargetTile, motion: MotionTile, lane: int) -> Any:
    """R7.4: the same where targets move, a `layout.MovingTargetFeatures`; `motion`, of the target."""
    heading_cos, heading_sin = heading_in_frame_of(me, motion.sine, motion.cosine, lane)
    moving = MotionFeatures(heading_cos=heading_cos, heading_sin=heading_sin, linear_velocity=motion.speed)
    seen = target_seen(me, target, lane)
    return MovingTargetFeatures(*seen[:], *moving[:])  # Numba unpacks plain tuples only


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
