"""A.5: which seed an episode has: one that is given, the one that follows another, or a row's of a batch."""

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.random import advance_seeds, derive_row_seeds
from catch_arena.seeding import checked_seed, fresh_seed


def next_seeds(seeds: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """A.5: the seeds of the episodes that follow, where a reset names none: (n,)."""
    following = seeds.copy()
    advance_seeds(following)
    return following


def episode_seed(given: int | None, before: int | None) -> int:
    """The seed of one arena's next episode.

    Args:
        given: a whole number in [0, 2^64), or None.
        before: the seed of the episode before, which it then follows (A.5); None for a first one, which is the
            operating system's.

    Raises:
        ConfigError: for a seed outside [0, 2^64).
    """
    if given is not None:
        return checked_seed(given)
    return fresh_seed() if before is None else int(next_seeds(np.array([before], dtype=np.uint64))[0])


def batch_seeds(seed: int, num_arenas: int) -> NDArray[np.uint64]:
    """A.5: the seeds of a batch's rows from one seed: (B,)."""
    seeds = np.zeros(num_arenas, dtype=np.uint64)
    derive_row_seeds(np.uint64(seed), seeds)
    return seeds
