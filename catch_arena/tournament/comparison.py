"""Comparison of two agents, A and B: blocks are played until a sequential test decides which is stronger."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution.block_queue import ForfeitStreaks, play_blocks
from catch_arena.tournament.execution.executors import Worker, local_executor
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.match import MAX_FORFEITS, Block, Match, PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.secret import Secret
from catch_arena.tournament.statistics.intervals import Estimate, shares
from catch_arena.tournament.statistics.outcomes import SideMatch, on_side
from catch_arena.tournament.statistics.sprt import Decision, Sprt

_A, _B, _FIELD = range(3)
"""Indices among the entrants: the two that are compared, and the first of their field."""


def comparison_block(matches: Iterable[Match], free: int) -> Block:
    """Return a block of a round robin with A, B and their field as players, if the field leaves `free` parties to both.

    If one is free, A and B take it in turn, in every seat and with the same seeds, in twice as many matches. Otherwise
    both sit in the same match, and share the free parties.
    """
    found = []
    for match in matches:
        for turn in (0, 1) if free == 1 else (0,):
            seating = [_FIELD + role - free if role >= free else (role + turn) % 2 for role in match.seating]
            found.append(replace(match, id=f"{match.id}-{'ab'[turn]}", seating=tuple(seating)))
    return tuple(found)


def share_of_a(block: Sequence[PlayedMatch], parties: Parties, free: int) -> float:
    """Return A's share against B in a block, in [0, 1]: a better rank counts 1, an equal one counts one half.

    With prey, all ranks on a side in the block are compared: in one match A and B may be on different sides.
    """
    compared = [on_side(block, parties, side) for side in parties.sides]
    if len(compared) == 1:
        (matches,), step = compared, 2 if free == 1 else 1
        compared = [matches[begin : begin + step] for begin in range(0, len(matches), step)]
    shares = [_share(matches) for matches in compared]
    return sum(shares) / len(shares)


def _share(matches: Sequence[SideMatch]) -> float:
    """Return A's share against B in all comparisons of their ranks in these matches, in [0, 1]."""
    ranks: tuple[list[int], list[int]] = ([], [])
    for one in matches:
        for index, rank in zip(one.seating, one.ranks, strict=True):
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
    matches: int
    share: Estimate
    """A's share against B, in [0, 1]. As the test stops at an extreme, it lies on average a little beyond the truth."""
    log_likelihood_ratio: float
    forfeits: Mapping[str, Mapping[str, int]]
    """Number of forfeited matches, by entrant's name and code; entrants without forfeits are left out."""


def compare(
    config: ArenaConfig,
    entrants: Sequence[Entrant],
    test: Sprt,
    *,
    max_blocks: int,
    seed: Secret | int | None = None,
    jobs: int = 1,
    quotas: Quotas | None = None,
    progress: Callable[[int, int], None] = lambda *_: None,
) -> Comparison:
    """Play until `test` has decided, or for `max_blocks` blocks.

    The entrants are the two to compare, then their field; without `quotas` all are trusted. The blocks are given to the
    test in the order of the plan, so the result does not depend on `jobs`. MAX_FORFEITS forfeits in a row exclude an
    entrant. `progress` is called with (matches played, largest possible number of matches) after each block.
    """
    parties, field = Parties.of(config), len(entrants) - _FIELD
    group = parties.group
    fitting = [size for size in range(group) if size == group - 1 or (group - size) % 2 == 0]
    if field not in fitting:
        raise ConfigError(
            f"the field (--against) must be of {' or '.join(map(str, fitting))} agents, got {field}: a block "
            f"has {group} players, and A and B share what the field leaves free, or play it in turn"
        )
    if group < 2:
        raise ConfigError(f"the scenario must be for at least 2 agents, got {group}")
    free = group - field
    plan = round_robin(group, parties, max_blocks, Secret.of(seed).part("compare"))
    most = plan.size * (2 if free == 1 else 1)
    shares_of_a: list[float] = []
    matches = 0
    forfeits: dict[str, Counter[str]] = {}
    with local_executor(Worker(config, tuple(entrants), quotas=quotas), jobs) as executor:
        blocks = (comparison_block(block, free) for block in plan.blocks())
        for block in play_blocks(blocks, executor, ForfeitStreaks(MAX_FORFEITS)):
            played = [one for one, _ in block]
            shares_of_a.append(share_of_a(played, parties, free))
            test.add(shares_of_a[-1])
            for one in played:
                for index, forfeit in zip(one.match.seating, one.result.forfeits, strict=True):
                    if forfeit is not None:
                        forfeits.setdefault(entrants[index].name, Counter())[forfeit.code] += 1
            matches += len(played)
            progress(matches, most)
            if test.decision is not None:
                break
    column = np.array(shares_of_a)[:, None]
    (share,) = shares(column, np.ones_like(column))
    return Comparison(test.decision, len(shares_of_a), matches, share, test.log_likelihood_ratio, forfeits)
