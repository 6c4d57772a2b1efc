"""Plans of matches: groups of entrants, in blocks where each sits in each seat, in one of two formats."""

import hashlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import combinations
from math import comb
from typing import Final, Protocol

from catch_arena.config import ArenaConfig, require_choice
from catch_arena.errors import ConfigError
from catch_arena.scenarios import SCENARIOS
from catch_arena.tournament.match import Block, Match, PlayedMatch, blocks_of
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.balanced_groups import groups_in_sweep, sweeps, sweeps_to_meet
from catch_arena.tournament.secret import Secret

FORMATS: Final = ("round-robin", "gauntlet")

_MOST_MATCHES: Final = 1_000_000
_MOST_ROUNDS: Final = 99_999
"""As many as the ids have room for."""
MOST_IN_A_ROUND: Final = 20_000
"""Matches of a round; of more groups a balanced sample is played."""
_BLOCKS_OF_EACH: Final = 10
"""Blocks that each entrant plays at least if no number of rounds is given: all figures have an interval then."""


class Plan(Protocol):
    """What is played, in stages: the blocks of one stage do not depend on each other's results."""

    @property
    def parameters(self) -> Mapping[str, str | int | float]:
        """What it follows from, but for its secret: with as many entrants and seats, equal ones make equal plans."""

    @property
    def size(self) -> int:
        """How many matches it has; the most that it may have, where it depends on their results."""

    def stage(self, number: int, played: Iterable[PlayedMatch]) -> Iterable[Block]:
        """The blocks of a stage, from 0 up; none after the last one.

        Args:
            number: which stage, from 0.
            played: all matches of the stages before.
        """


@dataclass(frozen=True, slots=True)
class FixedPlan:
    """A plan of one stage, whose blocks are made anew whenever they are walked: none is held."""

    parameters: Mapping[str, str | int]
    size: int
    blocks: Callable[[], Iterator[Block]] = field(repr=False)

    def __len__(self) -> int:
        return self.size

    def __iter__(self) -> Iterator[Match]:
        return (match for block in self.blocks() for match in block)

    def stage(self, number: int, played: Iterable[PlayedMatch]) -> Iterable[Block]:
        """All of it."""
        del played
        return () if number else self.blocks()


def plan_of(
    wanted: str,
    entrants: int,
    seats: int,
    rounds: int | None,
    seed: Secret | int,
    parties: Parties | None = None,
    most: int = MOST_IN_A_ROUND,
) -> FixedPlan:
    """The plan of a format.

    Args:
        wanted: one of FORMATS.
        entrants: who plays.
        seats: how many play in a block: `Parties.group`.
        rounds: None for the fewest in which each entrant plays ten blocks, so that its figures have intervals.
        seed: all that is drawn follows from it; a whole number in [0, 2^64) can be guessed.
        parties: those of the arena, where there is prey; without, a block is every rotation of its players.
        most: matches of a round; of more groups a balanced sample is played.

    Raises:
        ConfigError: for an unknown format, no rounds, and too few entrants or too many matches for it.
    """
    require_choice("format", wanted, FORMATS)
    challengers = int(wanted == "gauntlet")
    groups = comb(entrants - challengers, seats - challengers)
    make: Callable[..., FixedPlan] = gauntlet if challengers else round_robin
    if groups * _block_size(seats, parties) > most:
        make = partial(gauntlet, sampled=True) if challengers else balanced
    if rounds is None:
        # a challenger sits in every block; the others share what it leaves free
        places = make(entrants, seats, 1, seed, parties).size // _block_size(seats, parties) * (seats - challengers)
        rounds = -(-_BLOCKS_OF_EACH * (entrants - challengers) // max(places, 1))
    return make(entrants, seats, rounds, seed, parties)


def round_robin(
    entrants: int, seats: int, rounds: int, seed: Secret | int, parties: Parties | None = None
) -> FixedPlan:
    """In each round, one block for each subset of `seats` entrants.

    A block has one seed, draws a circular order of its players, and plays every rotation of it: each player sits in
    each seat once. All is drawn from `seed` alone; a plan with more rounds begins with the plan with fewer.
    """
    return _plan("round-robin", entrants, seats, rounds, seed, parties)


def balanced(entrants: int, seats: int, rounds: int, seed: Secret | int, parties: Parties | None = None) -> FixedPlan:
    """In each round, as few blocks as have a meeting for each pair, with everybody in as many of them.

    How often a pair meets differs by as little as the swaps of `balanced_groups.sweeps` can make it.
    """
    return _plan("balanced", entrants, seats, rounds, seed, parties, sampled=True)


def gauntlet(
    entrants: int, seats: int, rounds: int, seed: Secret | int, parties: Parties | None = None, *, sampled: bool = False
) -> FixedPlan:
    """The first entrant in every block, against each subset of the others, or against balanced groups of them."""
    if seats < 2:
        raise ConfigError(f"format gauntlet needs at least 2 hunters in a match, got {seats}")
    return _plan("gauntlet", entrants, seats, rounds, seed, parties, challengers=1, sampled=sampled)


def listed(matches: Sequence[Match]) -> FixedPlan:
    """The plan of these very matches, which stand by block."""
    text = "\n".join(f"{match.id} {match.block} {match.seed} {match.seating}" for match in matches)
    parameters = {"format": "listed", "digest": hashlib.blake2b(text.encode(), digest_size=8).hexdigest()}
    return FixedPlan(parameters, len(matches), lambda: iter(blocks_of(matches)))


def require_enough(entrants: int, config: ArenaConfig, scenario: str, *, tournament: bool = False) -> None:
    """Require as many entrants as fill the seats.

    Args:
        entrants: how many there are.
        config: the arena's settings.
        scenario: what it is called.
        tournament: whether they are to fill a block, which with prey may have more players than a match.

    Raises:
        ConfigError: with advice, where the entrants cannot fill the seats.
    """

    def needed(config: ArenaConfig) -> int:
        parties = Parties.of(config)
        return parties.group if tournament else len(parties)

    least = needed(config)
    if entrants >= least:
        return
    task = f"{Parties.of(config).task} of {scenario}"
    if least > len(Parties.of(config)):
        task += " in a tournament, where whoever is alone on a side takes turns with one more, to be compared"
    fitting = [name for name, other in SCENARIOS.items() if 1 < needed(other) <= entrants]
    advice = f"; or try --scenario {fitting[0]}" if fitting else ""
    raise ConfigError(
        f"agents must be at least {least} to {task}, got {entrants}: "
        f"name more of them (the same one may be named twice){advice}"
    )


def _check(rounds: int, size: int, what: str) -> None:
    """Require a plan that can be played.

    Raises:
        ConfigError: for a plan that cannot be, or that is too long.
    """
    if not 1 <= rounds <= _MOST_ROUNDS:
        raise ConfigError(f"rounds must be at least 1 and at most {_MOST_ROUNDS}, got {rounds}")
    if size > _MOST_MATCHES:
        raise ConfigError(
            f"a plan must have at most {_MOST_MATCHES} matches, got {size}: {what}, in every seating, {rounds} rounds"
        )


def _block_size(seats: int, parties: Parties | None) -> int:
    """How many matches a block has."""
    return seats if parties is None else parties.block_size


def _block(
    group: Sequence[int], secret: Secret, number: int, index: int, groups: int, parties: Parties | None
) -> Block:
    """Every rotation of a drawn circle of the group.

    Args:
        group: who plays in the block.
        secret: what its seeds and its circle are drawn from.
        number: its round's, from 0.
        index: its own in the round, from 0.
        groups: how many a round has.
        parties: as of `plan_of`.
    """
    block = number * groups + index
    order = sorted(group, key=lambda player: secret.seed("seating", block, player))
    agent_seeds = {player: secret.seed("agent", block, player) for player in group}
    rotations = [(*order[turn:], *order[:turn]) for turn in range(len(order))]
    seatings = rotations if parties is None else list(parties.seatings(order))
    digits = max(2, len(str(len(seatings) - 1)))  # ids sort as the plan does
    return tuple(
        Match(
            id=f"r{number + 1:05d}-g{index + 1:06d}-s{turn:0{digits}d}",
            block=block,
            seed=secret.seed("match", block),
            seating=seating,
            agent_seeds=tuple(agent_seeds[player] for player in seating),
        )
        for turn, seating in enumerate(seatings)
    )


def _plan(
    name: str,
    entrants: int,
    seats: int,
    rounds: int,
    seed: Secret | int,
    parties: Parties | None,
    *,
    challengers: int = 0,
    sampled: bool = False,
) -> FixedPlan:
    """Blocks of the challengers, who come first and play in each, and of groups of the others: all, or a sample."""
    secret = Secret.of(seed)
    others, free = entrants - challengers, seats - challengers
    if sampled:
        turns, count = rounds * sweeps_to_meet(others, free), groups_in_sweep(others, free)
        what = f"balanced blocks of {entrants} entrants"
    else:
        turns, count = rounds, comb(others, free)
        what = f"{'one against ' if challengers else ''}every {free} of {others} entrants"
    size = turns * count * _block_size(seats, parties)
    _check(turns, size, what)

    def blocks() -> Iterator[Block]:
        drawn = sweeps(others, free, lambda *about: secret.seed("groups", *about))
        for number in range(turns):
            for index, group in enumerate(next(drawn) if sampled else combinations(range(others), free)):
                everybody = (*range(challengers), *(player + challengers for player in group))
                yield _block(everybody, secret, number, index, count, parties)

    return FixedPlan({"format": name, "rounds": rounds}, size, blocks)
