"""Reading of arenas in memory, for people and for the digest: views of them by content, worlds and rulings."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.core import rows
from catch_arena.core.memory import Sections, settings_in
from catch_arena.core.state import ALL_OPTIONS, regions_of
from catch_arena.core.vectors import LANES
from catch_arena.verdicts import NO_REQUEST, Ruling, Verdict
from catch_arena.world import HunterState, PreyState, TargetState, World


def row_of(offset: int) -> int:
    """Return the row at one of core/rows.py's offsets, which count numbers, LANES to a row."""
    return offset // LANES


_HUNTER_DIGEST: Final = np.array(rows.HUNTER_DIGEST) // LANES
"""A.8: rows of a hunter that the digest reads, in its order."""
_TARGET_DIGEST: Final = (np.array(rows.TARGET_DIGEST) // LANES, np.array(rows.MOVING_TARGET_DIGEST) // LANES)
"""A.8: rows of a target that the digest reads, in its order, if targets stand still and if they move."""
RULING: Final = slice(row_of(rows.RULING[0]), row_of(rows.RULING[-1]) + 1)
"""R5.6: rows of a hunter's answer: the target's number, 0 for none; verdict; distance [micrometres] and winner's seat,
-1 for none. Verdict 0 is no request, and the other rows then mean nothing.
"""


class ArenaViews(NamedTuple):
    """Views of an engine's arenas by content. Writing to a view writes to the arena."""

    config: ArenaConfig
    fields: NDArray[np.float64]
    """All rows of an arena; its own come first: [chunk, row, lane]."""
    hunters: NDArray[np.float64]
    """Rows of the hunters: [chunk, seat, row, lane]."""
    targets: NDArray[np.float64]
    """Rows of the target slots: [chunk, slot, row, lane]."""
    prey: NDArray[np.float64]
    """Rows of prey: [chunk, index, row, lane]."""
    target_orders: NDArray[np.int8]
    """Slots in the order in which each seat sees the targets: [chunk, seat, rank, lane]."""


def views_of(config: ArenaConfig, sections: Sections) -> ArenaViews:
    """Return views of the arenas in an engine's memory."""
    settings, number = settings_in(sections.settings, ALL_OPTIONS), len(sections.chunks)
    first_hunter, first_target, first_prey, end = map(row_of, regions_of(settings))
    fields = sections.chunks.reshape(number, end, LANES)
    slots = (number, config.max_targets, row_of(settings.slot_size), LANES)
    return ArenaViews(
        config,
        fields,
        hunters=fields[:, first_hunter:first_target].reshape(number, config.hunters, rows.HUNTER_ROWS, LANES),
        targets=fields[:, first_target:first_prey].reshape(slots),
        prey=fields[:, first_prey:].reshape(number, config.prey, rows.PREY_ROWS, LANES),
        target_orders=sections.target_orders.reshape(number, config.hunters, config.targets_seen, LANES),
    )


def _rows_of(views: ArenaViews, arena: int) -> tuple[NDArray[np.float64], ...]:
    """Return the rows of one arena: its own, (ARENA_ROWS,), those of each hunter, (H, HUNTER_ROWS), those of each alive
    target that the digest reads, and those of each prey, (P, PREY_ROWS).
    """
    chunk, lane = divmod(arena, LANES)
    own = views.fields[chunk, : rows.ARENA_ROWS, lane]
    targets = views.targets[chunk, : int(own[row_of(rows.ALIVE)]), :, lane]
    read = targets.take(_TARGET_DIGEST[views.config.targets_move], axis=1)
    return own, views.hunters[chunk, :, :, lane], read, views.prey[chunk, :, :, lane]


def rulings_in(views: ArenaViews, arena: int) -> tuple[Ruling, ...]:
    """R5.6: return the verdicts of the last step with their evidence, by seat."""
    own, hunters, _, _ = _rows_of(views, arena)
    found, steps = [], int(own[row_of(rows.STEP)])
    for seat, (number, verdict, distance, winner) in enumerate(hunters[:, RULING].tolist()):
        if verdict == NO_REQUEST:
            continue
        step = steps if verdict == Verdict.MATCH_OVER else steps - 1
        target = views.config.target_name(int(number)) if number else None
        found.append(Ruling.of_numbers(verdict, seat, target, distance, winner, step))
    return tuple(found)


def world_in(views: ArenaViews, arena: int) -> World:
    """Return one arena as a World, with names."""
    config = views.config
    own, hunters, targets, prey = _rows_of(views, arena)
    played = _numbers_played(targets, prey).tolist() if config.prey else []
    players = dict(zip(played, config.prey_names, strict=True))
    return World(
        time_ms=int(own[row_of(rows.TIME)]),
        step=int(own[row_of(rows.STEP)]),
        side_m=config.side_m,
        hunters=tuple(
            HunterState(
                name=name,
                x=x,
                y=y,
                theta=theta,
                linear_velocity=speed,
                angular_velocity=turn_rate,
                score=int(score),
                active_target=config.target_name(int(active)) if active else None,
                at_wall=at_wall > 0,
                withdrawn=withdrawn > 0,
                team=team,
            )
            for name, team, (x, y, theta, speed, turn_rate, _, _, active, score, at_wall, withdrawn) in zip(
                config.hunter_names, config.team_by_seat, hunters.take(_HUNTER_DIGEST, axis=1).tolist(), strict=True
            )
        ),
        targets=tuple(
            TargetState(
                name=config.target_name(int(number)),
                number=int(number),
                x=x,
                y=y,
                theta=theta,
                spawned_ms=int(appeared),
                linear_velocity=motion[0] if motion else 0.0,
                angular_velocity=motion[1] if motion else 0.0,
                at_wall=bool(motion and motion[2]),
                prey=players.get(number),
            )
            for number, x, y, theta, appeared, *motion in targets.tolist()
        ),
        rulings=rulings_in(views, arena),
        spawned=int(own[row_of(rows.SPAWNED)]),
        prey=tuple(
            PreyState(
                name=name,
                target=config.target_name(int(number)) if number else None,
                times_caught=int(me[row_of(rows.TIMES_CAUGHT)]),
                caught_ms=None if number else int(me[row_of(rows.CAUGHT_AT)]),
                caught_by=None if me[row_of(rows.CAUGHT_BY)] < 0 else int(me[row_of(rows.CAUGHT_BY)]),
                withdrawn=me[row_of(rows.PREY_WITHDRAWN)] > 0,
            )
            for name, number, me in zip(config.prey_names, played, prey.tolist(), strict=True)
        ),
    )


def state_in(views: ArenaViews, arena: int) -> NDArray[np.float64]:
    """A.8: return the numbers of one arena's state, (n,), in the order in which the digest reads them."""
    own, hunters, targets, prey = _rows_of(views, arena)
    parts = [own[: rows.ARENA_DIGEST_ROWS], hunters.take(_HUNTER_DIGEST, axis=1), targets]
    if len(prey):
        times = prey[:, [row_of(rows.TIMES_CAUGHT), row_of(rows.CAUGHT_AT)]]
        parts.append(np.column_stack((_numbers_played(targets, prey), times)))
    return np.concatenate([part.reshape(-1) for part in parts])


def _numbers_played(targets: NDArray[np.float64], prey: NDArray[np.float64]) -> NDArray[np.float64]:
    """R12.1: return the numbers of the targets that prey plays, 0 for prey that is out: (P,)."""
    numbers = np.append(targets[:, 0], 0.0)  # the last one is for NO_TARGET, -1
    return numbers[prey[:, row_of(rows.PREY_SLOT)].astype(np.int64)]
