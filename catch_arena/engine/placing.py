"""Bodies put where somebody wants them, for tests, lessons, and positions to learn from."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.core import spawner, state
from catch_arena.core.jit import entry
from catch_arena.core.math import wrap
from catch_arena.core.memory import Bytes
from catch_arena.core.state import LANES, slot_rows
from catch_arena.engine.block_views import BlockViews, row_of


@entry
def _wrap_all(angles: NDArray[np.float64]) -> None:
    """A.2 of many angles, in place: (n,)."""
    for i in range(len(angles)):
        angles[i] = wrap(angles[i])


def _wrapped(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same of a table, where no zero has a sign."""
    turned = angles.flatten()
    _wrap_all(turned)
    return turned.reshape(angles.shape) + 0.0


def place(
    memory: Bytes,
    views: BlockViews,
    arena: int,
    hunters: Sequence[tuple[float, float, float]],
    targets: Sequence[tuple[float, float]],
    prey: Sequence[tuple[float, float, float]] | None = None,
) -> None:
    """As `Engine.place` says; nobody has observed it yet."""
    block, lane = divmod(arena, LANES)
    for seat, (x, y, theta) in enumerate(hunters):
        me = views.hunters[block, seat, :, lane]
        # 0.0 is added so that no zero has a sign
        me[[row_of(offset) for offset in (state.X, state.Y, state.THETA)]] = x + 0.0, y + 0.0, wrap(theta + 0.0)
        for offset in (*state.AT_REST, state.AT_WALL):
            me[row_of(offset)] = 0.0
    slots, players = views.targets[block, :, :, lane], views.prey_rows(arena)[:, row_of(state.PREY_SLOT)]
    played = np.sort(players[players != state.NO_TARGET]).astype(np.int64)
    kept = slots[played]
    slots[:] = 0.0
    slots[: len(played)] = kept
    views.fields[block, row_of(state.ALIVE), lane] = len(played)
    players[:] = [np.searchsorted(played, slot) if slot != state.NO_TARGET else slot for slot in players]
    for slot, (x, y, theta) in zip(players.astype(np.int64), prey or (), strict=prey is not None):
        if slot != state.NO_TARGET:
            pose = [row_of(state.BODY + offset) for offset in (state.X, state.Y, state.THETA)]
            slots[slot, pose] = x + 0.0, y + 0.0, wrap(theta + 0.0)
            for offset in (state.SPEED, state.TURN_RATE, state.AT_WALL):
                slots[slot, row_of(state.BODY + offset)] = 0.0
    for x, y in targets:
        spawner.spawn_at(memory, arena, float(x), float(y), 0.0)


def place_batch(
    config: ArenaConfig,
    views: BlockViews,
    arenas: NDArray[np.int64],
    hunters: NDArray[np.float64],
    targets: NDArray[np.float64],
    steps: NDArray[np.int64],
) -> None:
    """As `Engine.place_batch` says; nobody has observed it yet, and what was told of the last steps stands."""
    (block, lane), count = np.divmod(arenas, LANES), len(arenas)
    period = int(config.spawn_period_ms) if config.spawning else None
    time = steps * config.control_period_ms
    alive = ~np.isnan(targets[:, :, 0])
    own = {
        state.TIME: time,
        state.STEP: steps,
        state.SPAWNED: alive.sum(axis=1),
        state.LAST_NUMBER: alive.sum(axis=1),
        state.FIRINGS: 0 if period is None else time // period,
        state.ALIVE: alive.sum(axis=1),
    }
    for row in (*range(state.ARENA_DIGEST_ROWS), row_of(state.ALIVE), row_of(state.ENDED)):
        views.fields[block, row, lane] = own.get(row * LANES, 0.0)

    seats = np.zeros((count, config.hunters, state.HUNTER_ROWS))
    here = ~np.isnan(hunters[:, :, 0])
    for offset, column in ((state.X, 0), (state.Y, 1), (state.THETA, 2), (state.SPEED, 3)):
        seats[:, :, row_of(offset)] = np.where(here, hunters[:, :, column], 0.0)
    seats[:, :, row_of(state.THETA)] = _wrapped(seats[:, :, row_of(state.THETA)])
    seats[:, :, row_of(state.WITHDRAWN)] = ~here
    views.hunters[block, :, :, lane] = seats
    views.counters[block, :, :, lane] = 0.0

    age_ms = np.floor(1000.0 * targets[:, :, 4] + 0.5)
    order = np.argsort(np.where(alive, -age_ms, np.inf), axis=1, kind="stable")  # R8.2
    ranked = np.take_along_axis(targets, order[:, :, None], axis=1)
    there = np.take_along_axis(alive, order, axis=1)
    slots = np.zeros((count, config.max_targets, slot_rows(config.targets_move)))
    slots_used = slots[:, : targets.shape[1]]
    theta = _wrapped(ranked[:, :, 2]) if config.targets_move else ranked[:, :, 2]
    appeared = time[:, None] - np.take_along_axis(age_ms, order, axis=1)
    values = {
        state.NUMBER: np.arange(1, targets.shape[1] + 1)[None, :],
        state.APPEARED: appeared,
        state.TARGET_X: ranked[:, :, 0],
        state.TARGET_Y: ranked[:, :, 1],
        state.BODY + state.THETA: theta,
    }
    if config.targets_move:
        values[state.BODY + state.SPEED] = ranked[:, :, 3]
    for offset, value in values.items():
        slots_used[:, :, row_of(offset)] = np.where(there, value, 0.0)
    views.targets[block, :, :, lane] = slots
