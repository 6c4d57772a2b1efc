"""Comparison of two agents, A and B: blocks are played until a sequential test decides which is stronger."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, islice
from typing import Final

import numpy as np

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution.executors import local_executor
from catch_arena.tournament.execution.runner import play_plan
from catch_arena.tournament.execution.worker import Worker
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.match import Block, Match, PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.secret import Secret
from catch_arena.tournament.statistics.intervals import Estimate, shares
from catch_arena.tournament.statistics.sides import on_side
from catch_arena.tournament.statistics.sprt import Decision, Sprt
from catch_arena.tournament.store import Store, Tournament

_A, _B, _FIELD = range(3)
"""Indices among the entrants: the two that are compared, and the first of their field."""
_FIRST_STAGE: Final = 16


@dataclass(frozen=True, slots=True)
class ComparisonDesign:
    """Seats of A, B and their field in each block of a comparison; with prey each side is compared separately.

    If the field leaves one seat free, A and B take it in turn, in every seat and on the same targets. Otherwise both
    sit in the same match, and share the free seats.
    """

    parties: Parties
    field: int

    @property
    def seats(self) -> int:
        """Number of players in a block."""
        return self.parties.group

    def __post_init__(self) -> None:
        fitting = [size for size in range(self.seats) if size == self.seats - 1 or (self.seats - size) % 2 == 0]
        if self.field not in fitting:
            raise ConfigError(
                f"the field (--against) must be of {' or '.join(map(str, fitting))} agents, got {self.field}: a block "
                f"has {self.seats} players, and A and B share what the field leaves free, or play it in turn"
            )
        if self.seats < 2:
            raise ConfigError(f"the scenario must be for at least 2 agents, got {self.seats}")

    @property
    def in_turn(self) -> bool:
        """True if A and B play in turn, and never meet."""
        return self.seats - self.field == 1

    def block(self, matches: Iterable[Match]) -> tuple[Match, ...]:
        """Return a block of a round robin with A, B and their field as players; if A and B play in turn, twice as long.

        A player that takes another's place in turn gets the same seed.
        """
        free = self.seats - self.field
        found = []
        for match in matches:
            for turn in (0, 1) if self.in_turn else (0,):
                seating = [_FIELD + role - free if role >= free else (role + turn) % 2 for role in match.seating]
                found.append(replace(match, id=f"{match.id}-{'ab'[turn]}", seating=tuple(seating)))
        return tuple(found)

    def share_of_a(self, block: Sequence[PlayedMatch]) -> float:
        """Return A's share against B in a block, in [0, 1]: a better rank counts 1, an equal one counts one half.

        With prey, all ranks on a side in the block are compared: in one match A and B may be on different sides.
        """
        if len(self.parties.sides) > 1:
            sides = [on_side(block, self.parties, side) for side in self.parties.sides]
            return sum(_share(side) for side in sides) / len(sides)
        step = 2 if self.in_turn else 1
        shares = [_share(block[begin : begin + step]) for begin in range(0, len(block), step)]
        return sum(shares) / len(shares)


def _share(matches: Sequence[PlayedMatch]) -> float:
    """Return A's share against B in all comparisons of their ranks in these matches, in [0, 1]."""
    ranks: tuple[list[int], list[int]] = ([], [])
    for one in matches:
        for index, rank in zip(one.match.seating, one.result.ranks, strict=True):
            if index in (_A, _B):
                ranks[index].append(rank)
    found = [0.5 + 0.5 * ((mine < theirs) - (mine > theirs)) for mine in ranks[_A] for theirs in ranks[_B]]
    return sum(found) / len(found)


@dataclass(frozen=True, slots=True)
class Comparison:
    """Result of a comparison."""

    decision: Decision | None
    """Decision of the test; None if the blocks ran out first."""
    blocks: int
    """Number of blocks that the test needed."""
    matches: int
    share: Estimate
    """A's share against B, in [0, 1]. As the test stops at an extreme, it lies on average a little beyond the truth."""
    log_likelihood_ratio: float
    forfeits: Mapping[str, Mapping[str, int]]
    """Number of forfeited matches, by entrant's name and code; entrants without forfeits are left out."""


class _UntilDecided:
    """Plan of larger and larger stages, as long as the test has not decided."""

    def __init__(
        self,
        design: ComparisonDesign,
        test: Sprt,
        max_blocks: int,
        secret: Secret,
        progress: Callable[[int, Sprt], None],
    ) -> None:
        plan = round_robin(design.seats, design.parties, max_blocks, secret.part("compare"))
        self.parameters: Mapping[str, str | int | float] = {"format": "compare", "rounds": max_blocks}
        self.size = plan.size * (2 if design.in_turn else 1)
        self.shares: list[float] = []
        self.matches = 0
        """Number of matches in the blocks that the test needed."""
        self._design, self._test, self._progress = design, test, progress
        self._blocks = map(design.block, plan.blocks())
        self._seen, self._next_size = 0, _FIRST_STAGE

    def stage(self, number: int, played: Iterable[PlayedMatch]) -> Iterable[Block]:
        """Return the next stage, after giving the last one to the test in the order of the plan."""
        for _, block in groupby(islice(played, self._seen, None), key=lambda one: one.match.block):
            matches = list(block)
            self._seen += len(matches)
            if self._test.decision is None:
                self.shares.append(self._design.share_of_a(matches))
                self._test.add(self.shares[-1])
                self.matches += len(matches)
        if number:
            self._progress(len(self.shares), self._test)
        if self._test.decision is not None:
            return ()
        size = self._next_size
        self._next_size += size // 2
        return islice(self._blocks, size)


def compare(
    config: ArenaConfig,
    entrants: Sequence[Entrant],
    test: Sprt,
    *,
    max_blocks: int,
    seed: Secret | int | None = None,
    jobs: int = 1,
    limits: AgentLimits | None = None,
    max_forfeits: int = 0,
    progress: Callable[[int, Sprt], None] = lambda *_: None,
    on_played: Callable[[int, int], None] | None = None,
) -> Comparison:
    """Play until `test` has decided, or for `max_blocks` blocks.

    The blocks are given to the test in the order of the plan, so the decision does not depend on `jobs`.

    Args:
        config: the arena's settings.
        entrants: the two to compare, then their field.
        test: the sequential test.
        max_blocks: largest number of blocks.
        seed: source of all draws; an integer in [0, 2^64) can be guessed, None draws a new secret.
        jobs: number of processes that play.
        limits: limits of isolated agents; None if all are trusted.
        max_forfeits: number of forfeits in a row that exclude an entrant, as in `runner.play_plan`; 0 for no limit.
        progress: called with (blocks, test) after each stage.
        on_played: called with (matches played, largest possible number of matches) after each block.

    Raises:
        ConfigError: for max_blocks below 1, or a field that does not fit the scenario's seats.
        NoContest: if a match could not be held.
    """
    if max_blocks < 1:
        raise ConfigError(f"max_blocks must be at least 1, got {max_blocks}")
    secret = Secret.of(seed)
    design = ComparisonDesign(Parties.of(config), len(entrants) - _FIELD)
    plan = _UntilDecided(design, test, max_blocks, secret, progress)
    forfeits: dict[str, Counter[str]] = {}
    done = 0

    def count(played: Sequence[PlayedMatch]) -> None:
        nonlocal done
        done += len(played)
        for one in played:
            for index, code in zip(one.match.seating, one.result.forfeits, strict=True):
                if code is not None:
                    forfeits.setdefault(entrants[index].name, Counter())[code] += 1
        if on_played is not None:
            on_played(done, plan.size)

    with (
        Store.begin(Tournament(config, tuple(entrants), plan.parameters)) as store,
        local_executor(Worker(config, tuple(entrants), limits=limits), jobs) as executor,
    ):
        play_plan(store, plan, executor, max_forfeits=max_forfeits, on_results=count)
    column = np.array(plan.shares)[:, None]
    (share,) = shares(column, np.ones_like(column))
    return Comparison(test.decision, len(plan.shares), plan.matches, share, test.log_likelihood_ratio, forfeits)
