"""Seeds at the public interfaces: checks of given seeds, and new ones if none is given."""

import secrets
from typing import Final

from catch_arena.config import require_integer

SEED_LIMIT: Final = 2**64
"""A.5: upper bound of seeds, exclusive; the lower bound is 0."""


def checked_seed(seed: object) -> int:
    """Return a seed as an int.

    Raises:
        ConfigError: unless it is a whole number in [0, 2^64).
    """
    return require_integer("seed", seed, 0, SEED_LIMIT - 1)


def fresh_seed() -> int:
    """Return a seed from the operating system for a first reset without one: 32 bits, short enough to type."""
    return secrets.randbits(32)


def arena_seed(given: int | None) -> int:
    """Return the seed of a match that agents play; if none is given, one that agents cannot guess.

    Raises:
        ConfigError: unless it is a whole number in [0, 2^64).
    """
    return secrets.randbits(64) if given is None else checked_seed(given)
