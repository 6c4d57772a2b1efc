"""Plays a plan, in this process or in several; what comes out does not depend on how many there are."""

import os
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.engine import Engine
from catch_arena.errors import AgentError, ConfigError
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import MatchResult, play
from catch_arena.tournament.schedule import Match, blocks_of

_GRACE_S: Final = 1.0
"""How long workers may go on when a tournament is broken off, before they are ended."""


@dataclass(frozen=True, slots=True)
class Played:
    """A match of the plan, and what came out of it."""

    match: Match
    result: MatchResult


def run(
    config: ArenaConfig,
    entrants: Sequence[Entrant],
    matches: Sequence[Match],
    *,
    jobs: int = 1,
    record: Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[Played]:
    """Play every match; the results come in the order of the plan.

    Args: `jobs`, how many processes play, 1 for this one alone; `record`, a folder for one replay a match; `progress`,
    called with (matches played, matches in all) after each block.
    Raises: AgentError for the first agent that fails, OutputError for a replay that cannot be written; no process is
    left behind.
    """
    if jobs < 1:
        raise ConfigError(f"jobs must be at least 1, got {jobs}")
    blocks = blocks_of(matches)
    played: list[Played] = []

    def take(block: Sequence[Played]) -> None:
        played.extend(block)
        if progress is not None:
            progress(len(played), len(matches))

    if jobs == 1:
        for block in blocks:
            take(play_block(config, entrants, block, record))
    else:
        _run_in_processes(config, entrants, blocks, jobs=min(jobs, len(blocks)), record=record, take=take)
    return sorted(played, key=lambda one: one.match)


def usable_cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def play_block(
    config: ArenaConfig, entrants: Sequence[Entrant], block: Sequence[Match], record: Path | None
) -> list[Played]:
    """One block's matches, one after the other, each with fresh instances."""
    played = []
    for match in block:
        players = [entrants[place] for place in match.seating]
        try:
            result = play(
                config,
                match.seed,
                [player.create() for player in players],
                [player.name for player in players],
                places=match.seating,
                title=f"match {match.id}",
                record=None if record is None else record / f"{match.id}.replay",
            )
        except AgentError as error:
            raise AgentError(f"{error}, match {match.id}") from error
        played.append(Played(match, result))
    return played


def _run_in_processes(
    config: ArenaConfig,
    entrants: Sequence[Entrant],
    blocks: Sequence[Sequence[Match]],
    *,
    jobs: int,
    record: Path | None,
    take: Callable[[Sequence[Played]], None],
) -> None:
    Engine(config)  # compiled once here, and read from the cache there
    others = set(active_children())
    # spawned, not forked: the rules may have started threads here
    pool = ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=_leave_interrupts_to_the_parent)
    under_way: list[Future[list[Played]]] = []
    try:
        waiting = iter(blocks)
        while True:  # a few blocks ahead of the workers: a long plan is not held in memory twice
            for block in waiting:
                under_way.append(pool.submit(play_block, config, entrants, block, record))
                if len(under_way) >= 4 * jobs:
                    break
            if not under_way:
                break
            done = wait(under_way, return_when=FIRST_COMPLETED).done
            for future in [future for future in under_way if future in done]:  # in order: the first failure is told
                take(future.result())
                under_way.remove(future)
    except BrokenProcessPool:
        raise AgentError(
            "a worker process died: an agent may have ended it, or the memory ran out; --jobs 1 shows where"
        ) from None
    except BaseException:
        running = [future for future in under_way if not future.cancel()]
        if wait(running, timeout=_GRACE_S).not_done:
            for worker in set(active_children()) - others:
                worker.terminate()  # an agent may never return
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _leave_interrupts_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
