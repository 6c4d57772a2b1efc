"""What is played: every subset of the entrants that fills the seats, in blocks where each sits in each seat."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import comb
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.scenarios import SCENARIOS

_MOST_MATCHES: Final = 1_000_000


@dataclass(frozen=True, slots=True, order=True)
class Match:
    """One match of a plan."""

    id: str
    """The same for the same plan, whenever it is made; ids sort in the order of the plan."""
    block: int
    """Its block, from 0: matches of one block share their seed, and so their targets (R3.3)."""
    seed: int
    seating: tuple[int, ...]
    """By seat: the place of its player among the entrants."""


def round_robin(entrants: int, seats: int, rounds: int, seed: int) -> tuple[Match, ...]:
    """In each round, one block for each subset of `seats` entrants.

    A block has one seed, draws a circular order of its players, and plays every rotation of it: each player sits in
    each seat once. All is drawn from `seed` alone; a plan with more rounds begins with the plan with fewer.
    """
    if rounds < 1:
        raise ConfigError(f"rounds must be at least 1, got {rounds}")
    if seed < 0:
        raise ConfigError(f"seed must be a whole number from 0 up, got {seed}")
    size = rounds * comb(entrants, seats) * seats
    if size > _MOST_MATCHES:
        raise ConfigError(
            f"a plan must have at most {_MOST_MATCHES} matches, got {size}: "
            f"every {seats} of {entrants} entrants, {seats} seatings, {rounds} rounds"
        )
    groups = list(combinations(range(entrants), seats))
    matches = []
    for number in range(rounds):
        for index, group in enumerate(groups):
            about = (seed, number, *group)
            order = sorted(group, key=lambda player: _draw("order", *about, player))
            matches += [
                Match(
                    id=f"r{number + 1:05d}-g{index + 1:06d}-s{turn:02d}",
                    block=number * len(groups) + index,
                    seed=_draw("match", *about),
                    seating=(*order[turn:], *order[:turn]),
                )
                for turn in range(seats)
            ]
    return tuple(matches)


def blocks_of(matches: Sequence[Match]) -> list[tuple[Match, ...]]:
    """The matches by block, in the order of the plan."""
    blocks: dict[int, list[Match]] = {}
    for match in matches:
        blocks.setdefault(match.block, []).append(match)
    return [tuple(block) for block in blocks.values()]


def require_enough(entrants: int, config: ArenaConfig, scenario: str) -> None:
    """Raises: ConfigError with advice, where the entrants cannot fill the seats."""
    if entrants >= config.hunters:
        return
    fitting = [name for name, other in SCENARIOS.items() if 1 < other.hunters <= entrants]
    advice = f"; or try --scenario {fitting[0]}" if fitting else ""
    raise ConfigError(
        f"agents must be at least {config.hunters} to fill the seats of {scenario}, got {entrants}: "
        f"name more of them (the same one may be named twice){advice}"
    )


def _draw(*about: object) -> int:
    """48 bits that depend on these words alone; exact in a double, as JSON readers keep numbers."""
    text = "/".join(map(str, about))
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=6).digest(), "little")
