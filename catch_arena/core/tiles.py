"""What is known of each target and of each body, side by side.

What stands at a rank is another thing in each lane, so its numbers lie in other places. They are made for all things
first, once for all who look: a *tile* has those of one thing in one lane, a cache line long, and those of another one
in each lane are fetched by one load a lane.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.jit import Block, phase, rule
from catch_arena.core.state import (
    APPEARED,
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
from catch_arena.core.transfers import TILE, Place, put_exactly, put_rows, where_there
from catch_arena.core.vectors import Width, each, group


class BodyTile(NamedTuple):
    """What is known of a hunter, or of prey, in one lane."""

    x: float
    y: float
    sine: float
    cosine: float
    speed: float
    score: float
    """Of a hunter."""
    team: float
    """The seat that stands for a hunter's team."""


class TargetTile(NamedTuple):
    """What is known of a target in one lane: half a tile."""

    x: float
    y: float
    number: float
    age: float
    """[s]"""


class MotionTile(NamedTuple):
    """And of one that moves."""

    sine: float
    cosine: float
    speed: float


TILE_X: Final = 0
TILE_Y: Final = 1
"""Of both kinds."""
TILE_NUMBER: Final = TargetTile._fields.index("number")
_BODY_NUMBERS: Final = len(BodyTile._fields)
_TARGET_NUMBERS: Final = len(TargetTile._fields)
_MOVING_NUMBERS: Final = _TARGET_NUMBERS + len(MotionTile._fields)


@rule
def body_tile(body: Block, team: float, lane: int) -> BodyTile:
    """The tile of a body, of its rows up to SCORE and its team."""
    return BodyTile(
        x=body[X + lane],
        y=body[Y + lane],
        sine=body[SINE + lane],
        cosine=body[COSINE + lane],
        speed=body[SPEED + lane],
        score=body[SCORE + lane],
        team=team,
    )


@rule
def target_tile(block: Block, targets: Block, at: int, lane: int) -> TargetTile:
    """The tile of a target.

    Args:
        block: the block, for its row TIME [ms].
        at: where in `targets` its slot begins, its lane included.
    """
    age = (block[TIME + lane] - targets[APPEARED + at]) / 1000.0
    return TargetTile(targets[TARGET_X + at], targets[TARGET_Y + at], targets[NUMBER + at], age)


@rule
def motion_tile(targets: Block, at: int) -> MotionTile:
    """And where targets move; arguments as of `target_tile`."""
    return MotionTile(targets[BODY + SINE + at], targets[BODY + COSINE + at], targets[BODY + SPEED + at])


@rule
def body_of_tile(tile: tuple[float, ...]) -> BodyTile:
    """Its numbers by their names."""
    return BodyTile(*tile[:_BODY_NUMBERS])


@rule
def target_of_tile(tile: tuple[float, ...]) -> TargetTile:
    """Its numbers by their names."""
    return TargetTile(*tile[:_TARGET_NUMBERS])


@rule
def motion_of_tile(tile: tuple[float, ...]) -> MotionTile:
    """Its numbers by their names."""
    return MotionTile(*tile[_TARGET_NUMBERS:_MOVING_NUMBERS])


@rule
def tile_index(item: int, width: Width) -> int:
    """Where the tiles of a slot, seat or prey stand, in the lanes of one group: see `transfers.take_tile`."""
    return item * len(width) + each(0, width)


@phase
def put_tile(tiles: Block, item: int, width: Width, tile: tuple[float, ...]) -> None:
    """The tiles of a slot, seat or prey, in the lanes of one group; a tuple of four numbers is half of each."""
    put_rows(tiles, item * len(width) * TILE, TILE, tile)


@phase
def tile_targets(block: Block, targets: Block, first: int, width: Width, slots: int, s: Settings, tiles: Block) -> None:
    """What is known of every target, which all seats read, in the lanes of one group.

    Args:
        slots: how many slots are in use in any lane.
        tiles: the result: see `memory.Sections`.
    """
    for slot in range(slots):
        lane = group(first, width)
        at = slot * s.slot_size + lane
        tile = target_tile(block, targets, at, lane)
        if s.targets_move:
            put_tile(tiles, slot, width, (*tile[:], *motion_tile(targets, at)[:]))
        else:
            put_tile(tiles, slot, width, tile)


@phase
def tile_hunters(block: Block, first: int, width: Width, s: Settings, teams: NDArray[np.int64], tiles: Block) -> None:
    """The same of every hunter.

    Args:
        tiles: the result: see `memory.Sections`.
    """
    for seat in range(s.hunters):
        put_tile(tiles, seat, width, body_tile(seat_of(block, seat), float(teams[seat]), group(first, width)))


@phase
def put_rank(place: Place, there: bool, seen: tuple[float, ...], exactly: bool) -> None:
    """What is seen at one rank, in the lanes of one group.

    Args:
        there: whether anything is.
        seen: its columns.
        exactly: whether nothing is written behind them that would write over what is written too much.
    """
    columns = where_there(there, seen)
    if exactly:
        put_exactly(place.out, place.at, place.stride, columns)
    else:
        put_rows(place.out, place.at, place.stride, columns)
