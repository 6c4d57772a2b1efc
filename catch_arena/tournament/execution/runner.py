"""Runner of a plan, which stores blocks in the order of the plan; the results do not depend on the executor."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import count
from typing import Final

from catch_arena.files import prepare_folder, write_whole
from catch_arena.tournament.agent_logs import add_to_logs
from catch_arena.tournament.execution.block_queue import play_blocks
from catch_arena.tournament.execution.executors import Executor
from catch_arena.tournament.execution.forfeit_streaks import ForfeitStreaks
from catch_arena.tournament.execution.worker import RecordedMatch
from catch_arena.tournament.match import Block, PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import Plan
from catch_arena.tournament.store import Store

REPLAYS: Final = "replays"
LOGS: Final = "logs"
"""Names of folders in the tournament's folder: REPLAYS and LOGS."""


def play_plan(
    store: Store,
    plan: Plan,
    executor: Executor,
    *,
    max_forfeits: int = 0,
    on_results: Callable[[Sequence[PlayedMatch]], None] = lambda _: None,
    on_planned: Callable[[int], None] = lambda _: None,
) -> None:
    """Play the matches of a plan that are not in the store yet, stage by stage, to the end of the plan.

    A stage is written to the store before it is played. A block is written when it and all earlier blocks have ended;
    agents' logs, and replays if the executor's worker makes them, are written to the store's folder.
    After an interruption, the same call continues from there; no process is left.

    Args:
        store: keeps the results.
        plan: the matches to play.
        executor: plays the matches.
        max_forfeits: number of forfeits in a row that exclude an entrant; 0 for no limit.
        on_results: called with the matches that were played before, and then with the matches of each block.
        on_planned: called with the number of planned matches, after each block of the plan.

    Raises:
        MatchFailedError: for a block that failed on our side three times.
        AgentError: for an agent that another machine does not have.
        OutputError: for logs and replays that cannot be written.
        StoreError: for results that cannot be written.
    """
    streaks = ForfeitStreaks(max_forfeits)
    before = list(store.played())
    streaks.add(before)
    on_results(before)
    planned = 0

    def report_progress(blocks: Iterable[Block]) -> Iterator[Block]:
        so_far = planned
        for block in blocks:
            so_far += len(block)
            on_planned(so_far)
            yield block

    for number in count():
        stage = store.plan(report_progress(plan.stage(number, store.played(planned))))
        if not stage:
            store.end()
            return
        planned += stage
        play_waiting(store, executor, streaks, on_results)


def play_waiting(
    store: Store,
    executor: Executor,
    streaks: ForfeitStreaks,
    on_results: Callable[[Sequence[PlayedMatch]], None],
) -> None:
    """Play the blocks that are planned and not played; the arguments and errors are those of `play_plan`."""
    tournament, folder = store.tournament, store.path.parent
    parties = Parties.of(tournament.config)

    def store_block(recorded: Sequence[RecordedMatch]) -> None:
        for one, replay in recorded:  # files first, so that every match in the store has its files
            if replay:
                write_whole(prepare_folder(folder / REPLAYS) / f"{one.match.id}.replay", replay)
            add_to_logs(folder / LOGS, tournament.entrants, parties, one)
        played = [one for one, _ in recorded]
        store.add(played)
        on_results(played)

    play_blocks(store.waiting(), executor, streaks, store_block)
