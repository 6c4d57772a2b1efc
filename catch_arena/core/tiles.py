"""Tiles: numbers of each target and each body, side by side.

Each lane has another target or body at a rank, so its numbers lie in other places. They are therefore computed for all
targets and bodies first, once for all observers. A *tile* has the numbers of one of them in one lane, a cache line
long. One load for each lane then fetches the tile at the lane's rank.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.core import rows
from catch_arena.core.jit import Rows, phase, rule
from catch_arena.core.state import Settings, seat_of
from catch_arena.core.transfers import TILE, Place, put_exactly, put_rows, where_present
from catch_arena.core.vectors import Width, group


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


@phase
def put_rank(place: Place, present: bool, seen: tuple[float, ...], is_last: bool) -> None:
    """Write the columns of one rank, in the lanes of one group.

    Args:
        present: whether anything is at the rank; otherwise zeros are written.
        seen: columns of the rank.
        is_last: whether the rank has the last columns: then no numbers are written after it, since nothing would
            overwrite them.
    """
    columns = where_present(present, seen)
    if is_last:
        put_exactly(place.out, place.at, place.stride, columns)
    else:
        put_rows(place.out, place.at, place.stride, columns)
