"""Plans of matches: groups of entrants, in blocks where each sits in each seat, in one of two formats."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from math import ceil, comb
from typing import Final, Protocol

from catch_arena.config import ArenaConfig, require_choice
from catch_arena.errors import ConfigError
from catch_arena.scenarios import SCENARIOS
from catch_arena.tournament.match import Block, Match, PlayedMatch
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
    parties: Parties,
    rounds: int | None,
    seed: Secret | int,
    most: int = MOST_IN_A_ROUND,
) -> FixedPlan:
    """The plan of a format: in each round a block for each group of entrants, or for a balanced sample of the groups.

    A block has one seed, draws a circular order of its players, and plays every rotation of it: each player sits in
    each seat once. All is drawn from `seed` alone; a plan with more rounds begins with the plan with fewer.

    Args:
        wanted: one of FORMATS; in a gauntlet the first entrant is in every group.
        entrants: how many there are.
        parties: those of the arena.
        rounds: None for the fewest in which each entrant plays ten blocks, so that its figures have intervals.
        seed: all that is drawn follows from it; a whole number in [0, 2^64) can be guessed.
        most: matches of a round; of more groups a sample is played: the fewest in which all play equally often and as
            many meetings as there are pairs take place (balanced_groups.py).

    Raises:
        ConfigError: for an unknown format, no rounds, and too few entrants or too many matches for it.
    """
    require_choice("format", wanted, FORMATS)
    secret = Secret.of(seed)
    first = range(int(wanted == "gauntlet"))
    others, free = entrants - len(first), parties.group - len(first)
    if not free:
        raise ConfigError(f"format gauntlet needs at least 2 hunters in a match, got {parties.group}")
    count, turns, what = comb(others, free), 1, f"every {free} of {others} entrants"
    sampled = count * parties.block_size > most
    if sampled:
        count, turns = groups_in_sweep(others, free), sweeps_to_meet(others, free)
        what = f"balanced blocks of {entrants} entrants"
    if rounds is None:
        rounds = ceil(_BLOCKS_OF_EACH * others / max(turns * count * free, 1))
    turns *= rounds
    size = turns * count * parties.block_size
    if not 1 <= turns <= _MOST_ROUNDS:
        raise ConfigError(f"rounds must be at least 1 and at most {_MOST_ROUNDS}, got {turns}")
    if size > _MOST_MATCHES:
        raise ConfigError(
            f"a plan must have at most {_MOST_MATCHES} matches, got {size}: {what}, in every seating, {turns} rounds"
        )

    def blocks() -> Iterator[Block]:
        drawn = sweeps(others, free, lambda *about: secret.seed("groups", *about))
        for turn in range(turns):
            for index, group in enumerate(next(drawn) if sampled else combinations(range(others), free)):
                players = (*first, *(player + len(first) for player in group))
                yield _block(players, secret, turn * count + index, f"r{turn + 1:05d}-g{index + 1:06d}", parties)

    return FixedPlan({"format": "balanced" if sampled and not first else wanted, "rounds": rounds}, size, blocks)


def round_robin(entrants: int, parties: Parties, rounds: int, seed: Secret | int) -> FixedPlan:
    """In each round, one block for each group of entrants."""
    return plan_of("round-robin", entrants, parties, rounds, seed, _MOST_MATCHES)


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


def _block(players: Sequence[int], secret: Secret, number: int, name: str, parties: Parties) -> Block:
    """Every seating of a drawn circle of these players; `number` counts blocks from 0, `name` begins their ids."""
    circle = sorted(players, key=lambda player: secret.seed("seating", number, player))
    agent_seeds = {player: secret.seed("agent", number, player) for player in players}
    seatings = list(parties.seatings(circle))
    digits = max(2, len(str(len(seatings) - 1)))  # ids sort as the plan does
    return tuple(
        Match(
            id=f"{name}-s{turn:0{digits}d}",
            block=number,
            seed=secret.seed("match", number),
            seating=seating,
            agent_seeds=tuple(agent_seeds[player] for player in seating),
        )
        for turn, seating in enumerate(seatings)
    )
