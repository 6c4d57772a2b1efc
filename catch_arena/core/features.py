"""Rulebook R7.1, R7.4, R12.4: features of one target, rival or other body in an observation, in the order of
layout.py's table, and the time left.
"""

from typing import Any

from catch_arena.core import rows
from catch_arena.core.jit import Rows, rule
from catch_arena.core.state import Settings
from catch_arena.core.tiles import BodyTile, TargetTile
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
def in_frame_of(me: BodyTile, east: float, north: float) -> tuple[float, float]:
    """R7.1: return the parts of a direction ahead of an observer, and to its left.

    Args:
        east: eastern distance from the observer to a place [m], or the cosine of a heading.
        north: northern distance from the observer to a place [m], or the sine of a heading.
    """
    return me.cosine * east + me.sine * north, me.cosine * north - me.sine * east


@rule
def body_seen(me: BodyTile, body: BodyTile) -> BodyFeatures:
    """R12.4: return the features of a body in another body's view."""
    forward, left = in_frame_of(me, body.x - me.x, body.y - me.y)
    heading_cos, heading_sin = in_frame_of(me, body.cosine, body.sine)
    return BodyFeatures(
        forward=forward,
        left=left,
        present=1.0,
        heading_cos=heading_cos,
        heading_sin=heading_sin,
        linear_velocity=body.speed,
    )


@rule
def rival_seen(me: BodyTile, rival: BodyTile) -> RivalFeatures:
    """R7.1: return the features of a hunter in another hunter's view."""
    body = body_seen(me, rival)
    return RivalFeatures(
        forward=body.forward,
        left=body.left,
        present=body.present,
        heading_cos=body.heading_cos,
        heading_sin=body.heading_sin,
        linear_velocity=body.linear_velocity,
        score_difference=rival.score - me.score,
    )


@rule
def team_rival_seen(me: BodyTile, rival: BodyTile, team: float) -> Any:
    """R7.4: return the features of a rival if there are teams, a `layout.TeamRivalFeatures`; `team`: the observer's."""
    seen, in_teams = rival_seen(me, rival), TeamFeatures(mate=select(rival.team == team, 1.0, 0.0))
    return TeamRivalFeatures(*seen[:], *in_teams[:])  # Numba unpacks plain tuples only


@rule
def target_seen(me: BodyTile, target: TargetTile, active: float) -> TargetFeatures:
    """R7.1: return the features of a target in a hunter's view; `active`: number of the hunter's active target."""
    forward, left = in_frame_of(me, target.x - me.x, target.y - me.y)
    return TargetFeatures(
        forward=forward,
        left=left,
        present=1.0,
        age=target.age,
        active=select(target.number == active, 1.0, 0.0),
    )


@rule
def moving_target_seen(me: BodyTile, target: TargetTile, active: float) -> Any:
    """R7.4: return the features of a moving target in a hunter's view, a `layout.MovingTargetFeatures`."""
    heading_cos, heading_sin = in_frame_of(me, target.cosine, target.sine)
    moving = MotionFeatures(heading_cos=heading_cos, heading_sin=heading_sin, linear_velocity=target.speed)
    seen = target_seen(me, target, active)
    return MovingTargetFeatures(*seen[:], *moving[:])  # Numba unpacks plain tuples only


@rule
def time_left_at(chunk: Rows, s: Settings, lane: int) -> float:
    """R7.1, R12.4: return the time left until the time limit [s]."""
    remaining = s.time_limit_ms - chunk[rows.TIME + lane]
    seconds: float = select(remaining > 0.0, remaining / 1000.0, 0.0)
    return seconds
