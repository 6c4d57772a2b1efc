"""Seeds at the public interfaces: checks of given seeds, and new ones if none is given."""

import secrets
from typing import Final

from catch_arena.config import require_integer

SEED_LIMIT: Final = 2**64
"""A.5: upper bound of seeds, exclusive; the lower bound is 0."""


def checked_seed(seed: object) -> int:
    """Return a seed as an int; raise ConfigError unless it is a whole number in [0, 2^64)."""
    return require_integer("seed", seed, 0, SEED_LIMIT - 1)


def arena_seed(given: object) -> int:
    """Return a checked seed; for None, one from the operating system, which agents cannot guess."""
    return secrets.randbits(64) if given is None else checked_seed(given)
