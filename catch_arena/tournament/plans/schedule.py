"""Plans of matches in one of two formats: groups of entrants, in blocks in which each sits in each seat.

They are of a number of rounds, or go on until the order of all entrants is clear (`UntilSeparated`).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, islice
from math import ceil, comb
from typing import Final

from catch_arena.config import require_choice
from catch_arena.errors import ConfigError
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import Block, Match, PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.balanced_groups import groups_in_sweep, sweeps, sweeps_to_meet
from catch_arena.tournament.secret import Secret
from catch_arena.tournament.statistics.outcomes import SideResults
from catch_arena.tournament.statistics.separation import Separation, next_look, separation

FORMATS: Final = ("round-robin", "gauntlet")

_MOST_MATCHES: Final = 1_000_000
_MOST_ROUNDS: Final = 99_999
"""Largest number of rounds, or of sweeps in all rounds together: match ids have five digits for it."""
MOST_IN_A_ROUND: Final = 20_000
"""Usual largest number of matches in a round of all groups; a larger one is a balanced sample of the groups."""
_BLOCKS_OF_EACH: Final = 10
"""Smallest number of blocks for each entrant if no rounds are given: all figures have an interval then."""
BUDGET: Final = 10_000
"""Usual largest number of matches of a plan that goes on until the order is clear."""


@dataclass
class Plan:
    """Matches to play, which are made again in each iteration; none is kept in memory."""

    parameters: Mapping[str, str | int | float]
    """Parameters of the plan, without its secret; equal ones make equal plans for as many entrants and seats."""
    size: int
    """Number of matches; the largest possible number if the plan may end earlier."""
    blocks: Callable[[], Iterator[Block]] = field(repr=False)
    """Makes all blocks, also those that are not played if the plan ends earlier."""

    def __iter__(self) -> Iterator[Match]:
        return (match for block in self.blocks() for match in block)

    def stages(self, played: Callable[[], Iterable[PlayedMatch]]) -> Iterator[Iterable[Block]]:
        """Yield the blocks of each stage, which do not depend on each other's results; this plan has one stage.

        `played` returns all matches of the stages so far, when those of a stage have been played.
        """
        del played
        yield self.blocks()


def plan_of(
    wanted: str,
    entrants: int,
    parties: Parties,
    rounds: int | None,
    seed: Secret | int,
    most: int | None = None,
) -> Plan:
    """Return the plan of a format: each round has a block for each group of entrants, or for a balanced sample of them.

    A block has one seed, draws a circular order of its players, and plays every rotation of it: each player sits in
    each seat once. In a gauntlet the first entrant is in every group. All is drawn from `seed` alone; a plan with more
    rounds begins with the plan with fewer. None as `rounds` stands for the fewest in which each entrant plays ten
    blocks, so that its figures have intervals.

    If all groups need more than `most` matches in a round, a sample is played, in which all play equally often: at most
    as many groups as give as many meetings as there are pairs, and at least one sweep (balanced_groups.py). None stands
    for such a sample, whole, instead of more than MOST_IN_A_ROUND matches.
    """
    require_choice("format", wanted, FORMATS)
    if entrants < parties.group:
        raise ConfigError(f"entrants must be at least {parties.group}, the number in a block, got {entrants}")
    secret = Secret.of(seed)
    first = range(int(wanted == "gauntlet"))
    others, free = entrants - len(first), parties.group - len(first)
    if not free:
        raise ConfigError(f"format gauntlet needs at least 2 hunters or teams in a match, got {parties.group}")
    count, turns, subject = comb(others, free), 1, f"every {free} of {others} entrants"
    parameters: dict[str, str | int | float] = {"format": wanted}
    sampled = count * parties.block_size > (MOST_IN_A_ROUND if most is None else most)
    if sampled:
        count, enough = groups_in_sweep(others, free), sweeps_to_meet(others, free)
        turns = enough if most is None else min(enough, max(1, most // (count * parties.block_size)))
        subject = f"balanced blocks of {entrants} entrants"
        if not first:
            parameters["format"] = "balanced"
        if turns < enough:
            parameters["matches_in_a_round"] = turns * count * parties.block_size
    if rounds is None:
        rounds = ceil(_BLOCKS_OF_EACH * others / (turns * count * free))
    if not 1 <= rounds <= _MOST_ROUNDS // turns:
        raise ConfigError(f"rounds must be at least 1 and at most {_MOST_ROUNDS // turns}, got {rounds}")
    turns *= rounds
    size = turns * count * parties.block_size
    if size > _MOST_MATCHES:
        why = f"{subject}, in every seating, {rounds} rounds"
        raise ConfigError(f"a plan must have at most {_MOST_MATCHES} matches, got {size}: {why}")

    def blocks() -> Iterator[Block]:
        drawn = sweeps(others, free, lambda *about: secret.seed("groups", *about))
        for turn in range(turns):
            for index, group in enumerate(next(drawn) if sampled else combinations(range(others), free)):
                players = (*first, *(player + len(first) for player in group))
                yield block_of(players, secret, turn * count + index, f"r{turn + 1:05d}-g{index + 1:06d}", parties)

    return Plan(parameters | {"rounds": rounds}, size, blocks)


def round_robin(entrants: int, parties: Parties, rounds: int, seed: Secret | int) -> Plan:
    """Return a plan with one block for each group of entrants in each round."""
    return plan_of("round-robin", entrants, parties, rounds, seed, _MOST_MATCHES)


def block_of(players: Sequence[int], secret: Secret, number: int, name: str, parties: Parties) -> Block:
    """Return the matches of block `number`: every seating of a drawn circle of players; `name` begins their ids."""
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


class UntilSeparated(Plan):
    """Plan that ends after the first stage, of whole rounds, whose standings have a clear order.

    The number of matches is not one of its parameters: a resumed tournament may raise it. `plan` has the largest number
    of rounds. The order is right with the probability `confidence`, in [0.5, 1); with prey the order of each side must
    be clear.
    """

    def __init__(self, plan: Plan, entrants: Sequence[Entrant], parties: Parties, confidence: float) -> None:
        if not 0.5 <= confidence < 1:
            raise ConfigError(f"until_separated must lie in [0.5, 1), such as 0.95, got {confidence}")
        if parties.group == 1:
            raise ConfigError(
                "until_separated needs at least 2 hunters or teams in a match, got 1: ratings compare rivals"
            )
        kept = {"format": plan.parameters["format"], "until_separated": confidence}
        super().__init__(kept, plan.size, plan.blocks)
        self._round = plan.size // parties.block_size // int(plan.parameters["rounds"])
        self._entrants, self._parties = entrants, parties
        # with two orders, each gets half of the allowed error
        self._confidence = confidence if len(parties.sides) == 1 else (1.0 + confidence) / 2.0
        self.last: Separation | None = None
        """Result of the last look at the standings; None before the first one."""

    def stages(self, played: Callable[[], Iterable[PlayedMatch]]) -> Iterator[Iterable[Block]]:
        """Yield the blocks of the rounds until each look at the standings; none after the order is clear."""
        begin, parties = 0, self._parties
        while begin * parties.block_size < self.size:
            end = ceil(next_look(begin) / self._round) * self._round
            yield islice(self.blocks(), begin, end)
            begin, matches = end, list(played())
            sides = (SideResults.of(self._entrants, matches, parties, side) for side in parties.sides)
            looks = [separation(side, self._confidence) for side in sides]
            self.last = max(looks, key=lambda look: (not look.clear, look.p))
            if self.last.clear:
                return
