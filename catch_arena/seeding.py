"""Seeds at the public interfaces: what people may give, and what is drawn where they give none."""

import secrets
from typing import Final

from catch_arena.errors import ConfigError
from catch_arena.plain import whole_number
from catch_arena.text import with_type

SEED_LIMIT: Final = 2**64
"""A.5: seeds are whole numbers from 0 to this, exclusive."""


def checked_seed(seed: object) -> int:
    """The seed as an int.

    Raises:
        ConfigError: unless it is a whole number in [0, 2^64).
    """
    number = whole_number(seed)
    if number is None or not 0 <= number < SEED_LIMIT:
        shown = with_type(seed) if number is None else number
        raise ConfigError(f"seed must be a whole number from 0 to 2^64 - 1, got {shown}")
    return number


def fresh_seed() -> int:
    """A seed from the operating system, for a first reset that names none; it is small enough to be typed again."""
    return secrets.randbits(32)


def arena_seed(given: int | None) -> int:
    """The seed of a match that agents play: where none is given, one that they cannot guess.

    Raises:
        ConfigError: unless it is a whole number in [0, 2^64).
    """
    return secrets.randbits(64) if given is None else checked_seed(given)
