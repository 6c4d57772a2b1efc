"""A.5: seeds of episodes: a given seed, the seed that follows another, or the seed of a batch's row."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.random import BATCH_ROW, draw, next_seed, stream
from catch_arena.seeding import arena_seed


def next_seeds(seeds: Any) -> NDArray[np.uint64]:
    """A.5: return the seeds of the episodes that follow if a reset names none; one uint64, or an array of them."""
    with np.errstate(over="ignore"):  # the hashes of A.5 are arithmetic modulo 2^64
        return np.asarray(next_seed(seeds))


def episode_seed(given: int | None, before: int | None) -> int:
    """Return the seed of one arena's next episode: the given one, or the one that follows the seed before (A.5). The
    operating system gives the first.
    """
    if given is not None or before is None:
        return arena_seed(given)
    return int(next_seeds(np.uint64(before)))


def batch_seeds(seed: int, num_arenas: int) -> NDArray[np.uint64]:
    """A.5: return the seeds of a batch's rows, which follow from one seed: (B,)."""
    rows: Any = np.arange(num_arenas, dtype=np.uint64)
    with np.errstate(over="ignore"):  # as in `next_seeds`
        return np.asarray(draw(stream(np.uint64(seed), BATCH_ROW), rows))
