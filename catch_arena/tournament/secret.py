"""Secret of a tournament, and the seeds that follow from it; docs/reference/seeds.md describes it in full.

Each seed is a keyed hash of its purpose: nothing about a seed can be computed from other seeds.
"""

import hashlib
import secrets
from dataclasses import dataclass, field
from string import hexdigits
from typing import Final, Literal

from catch_arena.errors import ConfigError
from catch_arena.seeding import SEED_LIMIT, checked_seed

Purpose = Literal["match", "agent", "seating", "groups", "compare", "grade", "suite"]
"""Purposes of draws, each of at most sixteen bytes (`person` of BLAKE2b)."""

_BYTES: Final = 16
_SEED_BYTES: Final = 8


@dataclass(frozen=True, slots=True)
class Secret:
    """Secret of 128 bits, the source of all draws in a tournament; its `repr` hides them, since errors are public."""

    key: bytes = field(repr=False)
    number: int | None = field(default=None, repr=False, compare=False)
    """Number that the secret was made from, which can be guessed; None if there is none."""

    @classmethod
    def of(cls, seed: "Secret | int | None") -> "Secret":
        """Return a secret as it is, the secret of a number, or for None a new one from the operating system."""
        if isinstance(seed, Secret):
            return seed
        if seed is None:
            return cls(secrets.token_bytes(_BYTES))
        number = checked_seed(seed)
        return cls(_hash(b"", _BYTES, "number", (number,)), number)

    @classmethod
    def parse(cls, text: str) -> "Secret":
        """Return the secret in a text: exactly 32 hexadecimal digits are its bits, any other text is a number."""
        if len(text) == 2 * _BYTES and set(text) <= set(hexdigits):
            return cls(bytes.fromhex(text))
        if text.isascii() and text.isdecimal() and len(text) <= len(str(SEED_LIMIT)) and int(text) < SEED_LIMIT:
            return cls.of(int(text))
        raise ConfigError(
            f"seed must be {2 * _BYTES} hexadecimal digits, or a whole number from 0 to 2^64 - 1, got {text[:80]!r}"
        )

    @property
    def text(self) -> str:
        """Text for `parse`: the number if the secret was made from one, else `digits`."""
        return self.digits if self.number is None else str(self.number)

    @property
    def digits(self) -> str:
        """The 128 bits, as 32 hexadecimal digits."""
        return self.key.hex()

    def seed(self, purpose: Purpose, *numbers: int) -> int:
        """Return a seed in [0, 2^63), which fits the integers of SQLite and Parquet.

        `numbers` are the indices of the draw, as in the table in docs/reference/seeds.md; each in [0, 2^64).
        """
        return int.from_bytes(_hash(self.key, _SEED_BYTES, purpose, numbers), "little") >> 1

    def part(self, purpose: Purpose, *numbers: int) -> "Secret":
        """Return a separate secret, for a part that draws with the same purposes again."""
        return Secret(_hash(self.key, _BYTES, purpose, numbers))


def _hash(key: bytes, size: int, purpose: str, numbers: tuple[int, ...]) -> bytes:
    message = b"".join(number.to_bytes(8, "little") for number in numbers)
    return hashlib.blake2b(message, digest_size=size, key=key, person=purpose.encode()).digest()


def agent_seed(seed: int, seat: int) -> int:
    """Return the seed of an agent, in [0, 2^63), in a match without a plan, whose seed a user gives."""
    return Secret.of(seed).seed("agent", 0, seat)
