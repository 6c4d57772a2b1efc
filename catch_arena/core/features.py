"""Rulebook R7.1, R7.4, R12.4: features of one target, rival or other body in an observation, in the order of
layout.py's table; the tiles from which they are computed; and the time left.

Each lane has another target or body at a rank, so its numbers lie in other places. They are therefore copied for all
targets and bodies first, once for all observers. A *tile* has the numbers of one of them in one lane, a cache line
long. One load for each lane then fetches the tile at the lane's rank.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.core import rows
from catch_arena.core.jit import Rows, phase, rule
from catch_arena.core.state import Settings, seat_of
from catch_arena.core.transfers import TILE, Place, put_exactly, put_rows, where_present
from catch_arena.core.vectors import Width, group, select
from catch_arena.layout import (
    BodyFeatures,
    MovingTargetFeatures,
    RivalFeatures,
    TargetFeatures,
    TeamRivalFeatures,
)


class BodyTile(NamedTuple):
    """Tile of a hunter, or of prey, in one lane."""

    x: float
    y: float
    sine: float
    cosine: float
    speed: float
    score: float
    """Catches of a hunter; unused for prey."""
    team: float
    """Seat that stands for a hunter's team; unused for prey."""


class TargetTile(NamedTuple):
    """Tile of a target in one lane; of a target that stands still, only the first half is written and read."""

    x: float
    y: float
    number: float
    age: float
    """Age of the target [s]."""
    sine: float
    cosine: float
    speed: float


TILE_X: Final = 0
TILE_Y: Final = 1
"""Index of the position in tiles of bodies and of targets."""
TILE_NUMBER: Final = TargetTile._fields.index("number")
_BODY_NUMBERS: Final = len(BodyTile._fields)
_TARGET_NUMBERS: Final = len(TargetTile._fields)


@rule
def body_tile(body: Rows, team: float, lane: int) -> BodyTile:
    """Return the tile of a body, from its rows up to SCORE and its team."""
    return BodyTile(
        x=body[rows.X + lane],
        y=body[rows.Y + lane],
        sine=body[rows.SINE + lane],
        cosine=body[rows.COSINE + lane],
        speed=body[rows.SPEED + lane],
        score=body[rows.SCORE + lane],
        team=team,
    )


@rule
def body_of_tile(tile: tuple[float, ...]) -> BodyTile:
    """Return the numbers of a body's tile by name."""
    return BodyTile(*tile[:_BODY_NUMBERS])


@rule
def target_of_tile(tile: tuple[float, ...]) -> TargetTile:
    """Return the numbers of a target's tile by name."""
    return TargetTile(*tile[:_TARGET_NUMBERS])


@phase
def put_tile(tiles: Rows, item: int, width: Width, tile: tuple[float, ...]) -> None:
    """Write the tiles of a slot, seat or prey, in the lanes of one group; a tuple of four numbers is half of each."""
    put_rows(tiles, item * len(width) * TILE, TILE, tile)


@phase
def tile_targets(chunk: Rows, s: Settings, first: int, width: Width, targets: Rows, slots: int, tiles: Rows) -> None:
    """Write the tiles of all targets, which all seats read, in the lanes of one group."""
    for slot in range(slots):
        lane = group(first, width)
        at = slot * s.slot_size + lane
        age = (chunk[rows.TIME + lane] - targets[rows.APPEARED + at]) / 1000.0
        still = targets[rows.TARGET_X + at], targets[rows.TARGET_Y + at], targets[rows.NUMBER + at], age
        if s.targets_move:
            body = targets[rows.BODY :]
            put_tile(tiles, slot, width, (*still, body[rows.SINE + at], body[rows.COSINE + at], body[rows.SPEED + at]))
        else:
            put_tile(tiles, slot, width, still)


@phase
def tile_hunters(chunk: Rows, s: Settings, first: int, width: Width, teams: NDArray[np.int64], tiles: Rows) -> None:
    """Write the tiles of all hunters, which all seats read, in the lanes of one group."""
    for seat in range(s.hunters):
        put_tile(tiles, seat, width, body_tile(seat_of(chunk, seat), float(teams[seat]), group(first, width)))


@rule
def in_frame_of(me: BodyTile, east: float, north: float) -> tuple[float, float]:
    """R7.1: return the parts of a direction ahead of an observer, and to its left. Its eastern and northern parts are
    distances to a place [m], or cosine and sine of a heading.
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
    score_difference = rival.score - me.score
    return RivalFeatures(*body_seen(me, rival)[:], score_difference)  # Numba unpacks plain tuples only


@rule
def team_rival_seen(me: BodyTile, rival: BodyTile, team: float) -> Any:
    """R7.4: return the features of a rival if there are teams, a `layout.TeamRivalFeatures`; `team`: the observer's."""
    mate = select(rival.team == team, 1.0, 0.0)
    return TeamRivalFeatures(*rival_seen(me, rival)[:], mate)


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
    return MovingTargetFeatures(*target_seen(me, target, active)[:], heading_cos, heading_sin, target.speed)


@rule
def time_left_at(chunk: Rows, s: Settings, lane: int) -> float:
    """R7.1, R12.4: return the time left until the time limit [s]."""
    remaining = s.time_limit_ms - chunk[rows.TIME + lane]
    seconds: float = select(remaining > 0.0, remaining / 1000.0, 0.0)
    return seconds


@phase
def put_rank(place: Place, present: bool, seen: tuple[float, ...], is_last: bool) -> None:
    """Write the columns of one rank, or zeros if nothing is there, in the lanes of one group. After the last rank's
    columns no other number is written, since nothing would overwrite it.
    """
    columns = where_present(present, seen)
    if is_last:
        put_exactly(place.out, place.at, place.stride, columns)
    else:
        put_rows(place.out, place.at, place.stride, columns)
