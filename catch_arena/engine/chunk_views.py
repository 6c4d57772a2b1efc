"""Views of the memory of a batch of arenas, by content: the chunks of core/rows.py, without a copy."""

from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.core import rows, state
from catch_arena.core.state import Regions, slot_rows
from catch_arena.core.vectors import LANES


def row_of(offset: int) -> int:
    """Return the row at one of core/rows.py's offsets, which count numbers, LANES to a row."""
    return offset // LANES


HUNTER_DIGEST: Final = [row_of(offset) for offset in rows.HUNTER_DIGEST]
"""A.8: rows of a hunter that the digest reads, in its order."""
RULING: Final = slice(row_of(rows.RULING[0]), row_of(rows.RULING[-1]) + 1)
"""Rows of a hunter's answer."""


def _target_digest(*, moving: bool) -> list[int]:
    return [row_of(offset) for offset in (rows.MOVING_TARGET_DIGEST if moving else rows.TARGET_DIGEST)]


@cache  # every copy of an engine needs them
def _digest_rows(regions: Regions, hunters: int, max_targets: int, *, moving: bool) -> NDArray[np.int64]:
    """A.8: return the rows that the digest reads before those of prey, in its order, if every slot has a target."""
    seats = row_of(regions.hunters) + rows.HUNTER_ROWS * np.arange(hunters)
    slots = row_of(regions.targets) + slot_rows(moving) * np.arange(max_targets)
    of_hunters = np.add.outer(seats, HUNTER_DIGEST)
    of_targets = np.add.outer(slots, _target_digest(moving=moving))
    return np.concatenate((np.arange(rows.ARENA_DIGEST_ROWS), of_hunters.reshape(-1), of_targets.reshape(-1)))


class ChunkViews:
    """Views of the chunks, each [chunk, ..., row, lane]; writing to a view writes to the arena.

    Args:
        config: the arenas' settings.
        regions: offsets of the rows in a chunk.
        chunks: (number of chunks, rows * LANES).
        target_orders: (number of chunks, H, ranks * LANES).
    """

    def __init__(
        self, config: ArenaConfig, regions: Regions, chunks: NDArray[np.float64], target_orders: NDArray[np.int8]
    ) -> None:
        hunters, prey = config.hunters, config.prey
        num_chunks, num_rows = len(chunks), row_of(regions.end)
        slot = slot_rows(config.targets_move)
        first_hunter, first_target, first_prey, end = map(row_of, regions)
        self.fields = chunks.reshape(num_chunks, num_rows, LANES)
        """All rows; the arena's own come first: [chunk, row, lane]."""
        self.hunters = self.fields[:, first_hunter:first_target].reshape(num_chunks, hunters, rows.HUNTER_ROWS, LANES)
        """Rows of the hunters: [chunk, seat, row, lane]."""
        self.targets = self.fields[:, first_target:first_prey].reshape(num_chunks, config.max_targets, slot, LANES)
        """Rows of the target slots: [chunk, slot, row, lane]."""
        self.target_orders = target_orders.reshape(num_chunks, hunters, config.targets_seen, LANES)
        """Slots in the order in which each seat sees the targets: [chunk, seat, rank, lane]."""
        self.prey = self.fields[:, first_prey:end].reshape(num_chunks, prey, rows.PREY_ROWS, LANES)
        """Rows of prey: [chunk, index, row, lane]."""
        self.target_digest = _target_digest(moving=config.targets_move)
        """A.8: rows of a slot that the digest reads, in its order."""
        self._digest_rows = _digest_rows(regions, hunters, config.max_targets, moving=config.targets_move)

    def hunter_rows(self, arena: int) -> NDArray[np.float64]:
        """Return one arena's hunters: (H, HUNTER_ROWS)."""
        return self.hunters[arena // LANES, :, :, arena % LANES]

    def prey_rows(self, arena: int) -> NDArray[np.float64]:
        """Return one arena's prey: (P, PREY_ROWS)."""
        return self.prey[arena // LANES, :, :, arena % LANES]

    def prey_numbers(self, arena: int) -> NDArray[np.float64]:
        """R12.1: return the target numbers that one arena's prey plays, 0 for prey that is out: (P,), a copy."""
        slots = self.prey_rows(arena)[:, row_of(rows.PREY_SLOT)].astype(np.int64)
        numbers = self.targets[arena // LANES, slots, row_of(rows.NUMBER), arena % LANES]
        return np.where(slots == rows.NO_TARGET, 0.0, numbers)

    def numbers_seen(self, seat: int) -> NDArray[np.int64]:
        """R7.1: return the numbers of the targets that one hunter sees in each lane, by rank, 0 for none:
        (chunks * LANES, ranks), a copy.
        """
        slots = self.target_orders[:, seat].swapaxes(1, 2)
        none = np.cumsum(slots == state.ABSENT, axis=2) > 0
        numbers = self.targets[:, :, row_of(rows.NUMBER)].swapaxes(1, 2)
        seen = np.take_along_axis(numbers, np.where(none, 0, slots).astype(np.int64), axis=2)
        return np.where(none, 0.0, seen).astype(np.int64).reshape(-1, slots.shape[2])

    def active_targets(self) -> NDArray[np.int64]:
        """R4.1: return the numbers of the hunters' active targets in each lane, 0 for none: (chunks * LANES, H)."""
        numbers = self.hunters[:, :, row_of(rows.ACTIVE)].swapaxes(1, 2).astype(np.int64)
        return numbers.reshape(-1, self.hunters.shape[1])

    def seeds(self) -> NDArray[np.uint64]:
        """Return the seeds of the current episodes, of all lanes: (chunks * LANES,)."""
        high, low = (
            self.fields[:, row_of(offset)].reshape(-1).astype(np.uint64) for offset in (rows.SEED_HIGH, rows.SEED_LOW)
        )
        return (high << np.uint64(32)) | low

    def state(self, arena: int) -> NDArray[np.float64]:
        """A.8: return the numbers of one arena's state, (n,), in the order in which the digest reads them."""
        chunk, lane = divmod(arena, LANES)
        own = self.fields[chunk, :, lane]
        alive = int(own[row_of(rows.ALIVE)])
        empty_slots = self.targets.shape[1] - alive
        numbers: NDArray[np.float64] = own[
            self._digest_rows[: len(self._digest_rows) - empty_slots * len(self.target_digest)]
        ]
        if not self.prey.size:
            return numbers
        times = self.prey_rows(arena)[:, [row_of(rows.TIMES_CAUGHT), row_of(rows.CAUGHT_AT)]]
        return np.concatenate((numbers, np.column_stack((self.prey_numbers(arena), times)).reshape(-1)))
