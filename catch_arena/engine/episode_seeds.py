"""A.5: seeds of episodes: a given seed, the seed that follows another, or the seed of a batch's row."""

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.random import advance_seeds, derive_row_seeds
from catch_arena.seeding import arena_seed


def next_seeds(seeds: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """A.5: return the seeds of the episodes that follow if a reset names none: (n,)."""
    following = seeds.copy()
    advance_seeds(following)
    return following


def episode_seed(given: int | None, before: int | None) -> int:
    """Return the seed of one arena's next episode.

    Args:
        given: a whole number in [0, 2^64), or None.
        before: the seed of the previous episode, from which the next one follows (A.5); None for the first episode,
            whose seed the operating system gives.

    Raises:
        ConfigError: for a seed outside [0, 2^64).
    """
    if given is not None or before is None:
        return arena_seed(given)
    return int(next_seeds(np.array([before], dtype=np.uint64))[0])


def batch_seeds(seed: int, num_arenas: int) -> NDArray[np.uint64]:
    """A.5: return the seeds of a batch's rows, which follow from one seed: (B,)."""
    seeds = np.zeros(num_arenas, dtype=np.uint64)
    derive_row_seeds(np.uint64(seed), seeds)
    return seeds
