"""Rulebook R12.4: what prey sees of itself, of the hunters and of other prey, in the order of layout.py's table.

One lane at a time: prey is few, and sees few.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.jit import Block, rare
from catch_arena.core.ranking import Keys, body_at, equally_far, item_of, key_of, lead
from catch_arena.core.state import (
    ARENA_ROWS,
    BODY,
    COSINE,
    HUNTER_ROWS,
    LANES,
    NO_TARGET,
    PREY_SLOT,
    SINE,
    SPEED,
    TIME,
    TIMES_CAUGHT,
    TURN_RATE,
    WITHDRAWN,
    Settings,
    X,
    Y,
    prey_of,
    seat_at,
)
from catch_arena.core.vectors import put_rows
from catch_arena.core.workspace import Scratch
from catch_arena.layout import MOST_SEEN_BY_PREY, BodyFeatures, PreySelfFeatures

_UNSEEN: Final = -1
_BODY_WIDTH: Final = len(BodyFeatures._fields)
_SELF_WIDTH: Final = len(PreySelfFeatures._fields)

Places = NDArray[np.int64]
"""Where in a block bodies are, their lane included; _UNSEEN for one that is not to be seen."""


@rare
def find_bodies(block: Block, s: Settings, lane: int, places: Places) -> None:
    """Where the hunters of one lane are, by seat, and then its prey, by index: (H + P,), the result."""
    for seat in range(s.hunters):
        at = seat_at(seat) + lane
        places[seat] = _UNSEEN if block[WITHDRAWN + at] > 0.0 else at
    slots = (ARENA_ROWS + s.hunters * HUNTER_ROWS) * LANES
    for index in range(s.prey):
        slot = int(prey_of(block, index, s)[PREY_SLOT + lane])
        places[s.hunters + index] = _UNSEEN if slot == NO_TARGET else slots + slot * s.slot_size + BODY + lane


@rare
def comes_first(block: Block, mine: int, places: Places, key: int, other: int) -> bool:
    """R12.4: whether the body of one key is seen before that of another."""
    if not equally_far(min(key, other), max(key, other)):
        return key < other
    return lead(body_at(block, mine, places[item_of(key)]), body_at(block, mine, places[item_of(other)])) > 0.0


@rare
def see_bodies(
    block: Block, mine: int, places: Places, myself: int, keys: Keys, out: NDArray[np.float32], at: int
) -> None:
    """R12.4: the nearest of some bodies, in their order.

    Args:
        block: the block.
        mine: where the observer's own body is, its lane included.
        places: the bodies.
        myself: which of them is the observer, or _UNSEEN.
        keys: room for as many as are seen.
        out: the observer's observation.
        at: where in it the columns of rank 1 begin; those of ranks that nobody has are left as they are.
    """
    seen = 0
    for item in range(len(places)):
        place = places[item]
        if place == _UNSEEN or item == myself:
            continue
        key = key_of(block[X + place] - block[X + mine], block[Y + place] - block[Y + mine], item)
        rank = seen
        while rank > 0 and comes_first(block, mine, places, key, keys[rank - 1]):
            rank -= 1
        if rank == MOST_SEEN_BY_PREY:
            continue
        seen = min(seen + 1, MOST_SEEN_BY_PREY)
        for behind in range(seen - 1, rank, -1):
            keys[behind] = keys[behind - 1]
        keys[rank] = key
    for rank in range(seen):
        put_rows(out, at + rank * _BODY_WIDTH, _BODY_WIDTH, body_at(block, mine, places[item_of(keys[rank])]))


@rare
def observe_as_prey(block: Block, s: Settings, lanes: int, scratch: Scratch, out: NDArray[np.float32]) -> None:
    """R12.4, R12.3: the observations of all prey: (lanes, P, E), the result."""
    prey_at = _SELF_WIDTH + min(s.hunters, MOST_SEEN_BY_PREY) * _BODY_WIDTH
    for lane in range(lanes):
        places = scratch.places
        find_bodies(block, s, lane, places)
        remaining = s.time_limit_ms - block[TIME + lane]
        time_left = remaining / 1000.0 if remaining > 0.0 else 0.0
        for index in range(s.prey):
            observation = out[lane, index]
            for column in range(len(observation)):
                observation[column] = 0.0
            mine = places[s.hunters + index]
            caught = prey_of(block, index, s)[TIMES_CAUGHT + lane]
            out_of_play = mine == _UNSEEN
            body = 0 if out_of_play else mine
            there = 0.0 if out_of_play else 1.0
            own = PreySelfFeatures(
                x=there * block[X + body],
                y=there * block[Y + body],
                heading_cos=there * block[COSINE + body],
                heading_sin=there * block[SINE + body],
                linear_velocity=there * block[SPEED + body],
                angular_velocity=there * block[TURN_RATE + body],
                time_left=time_left,
                times_caught=caught,
                alive=there,
            )
            put_rows(observation, 0, _SELF_WIDTH, own)
            if not out_of_play:
                see_bodies(block, mine, places[: s.hunters], _UNSEEN, scratch.keys, observation, _SELF_WIDTH)
                see_bodies(block, mine, places[s.hunters :], index, scratch.keys, observation, prey_at)
