"""A tournament's secret, and the seeds that follow from it; docs/tournaments.md, "Seeds", has it for other languages.

Each seed is a keyed hash of what it is for: whoever knows some of them knows nothing of the others.
"""

import hashlib
import secrets
from dataclasses import dataclass, field
from string import hexdigits
from typing import Final, Literal

from catch_arena.errors import ConfigError
from catch_arena.seeding import SEED_LIMIT, checked_seed

Purpose = Literal[
    "match",
    "agent",
    "seating",
    "groups",
    "compare",
    "grade",
    "suite",
]
"""What something is drawn for, each in at most sixteen bytes (BLAKE2b's `person`)."""

_BYTES: Final = 16
_SEED_BYTES: Final = 8
_LONGEST_NUMBER: Final = len(str(SEED_LIMIT))


@dataclass(frozen=True, slots=True)
class Secret:
    """128 bits, from which all follows that is drawn in a tournament. Its `repr` does not show them: errors may be read
    by anybody.
    """

    key: bytes = field(repr=False)
    number: int | None = field(default=None, repr=False, compare=False)
    """The number that it was made from, if any: then it can be guessed."""

    @classmethod
    def of(cls, seed: "Secret | int | None") -> "Secret":
        """A secret as it is, that of a number, or for None a fresh one from the operating system.

        Raises:
            ConfigError: for a number that is not in [0, 2^64).
        """
        if isinstance(seed, Secret):
            return seed
        if seed is None:
            return cls(secrets.token_bytes(_BYTES))
        number = checked_seed(seed)
        return cls(_hash(b"", _BYTES, "number", (number,)), number)

    @classmethod
    def parse(cls, text: str) -> "Secret":
        """Exactly 32 hexadecimal digits are a secret, anything else is a number.

        Raises:
            ConfigError: for a text that is neither.
        """
        if len(text) == 2 * _BYTES and set(text) <= set(hexdigits):
            return cls(bytes.fromhex(text))
        if text.isascii() and text.isdecimal() and len(text) <= _LONGEST_NUMBER and int(text) < SEED_LIMIT:
            return cls.of(int(text))
        raise ConfigError(
            f"seed must be {2 * _BYTES} hexadecimal digits, or a whole number from 0 to 2^64 - 1, got {text[:80]!r}"
        )

    @property
    def text(self) -> str:
        """What `parse` takes: the number, where it was made from one."""
        return self.digits if self.number is None else str(self.number)

    @property
    def digits(self) -> str:
        """32 hexadecimal digits."""
        return self.key.hex()

    def seed(self, purpose: Purpose, *numbers: int) -> int:
        """A whole number in [0, 2^63): so that SQLite's and Parquet's whole numbers hold it.

        Args:
            purpose: what is drawn.
            numbers: of what it is drawn, as the table in docs/tournaments.md says; each in [0, 2^64).
        """
        return int.from_bytes(_hash(self.key, _SEED_BYTES, purpose, numbers), "little") >> 1

    def part(self, purpose: Purpose, *numbers: int) -> "Secret":
        """A secret of its own, for what draws with the same purposes again."""
        return Secret(_hash(self.key, _BYTES, purpose, numbers))


def _hash(key: bytes, size: int, purpose: str, numbers: tuple[int, ...]) -> bytes:
    message = b"".join(number.to_bytes(8, "little") for number in numbers)
    return hashlib.blake2b(message, digest_size=size, key=key, person=purpose.encode()).digest()


def agent_seed(seed: int, seat: int) -> int:
    """What an agent is told as its seed, in [0, 2^63), in a match that is of no plan and has its seed from people."""
    return Secret.of(seed).seed("agent", 0, seat)
