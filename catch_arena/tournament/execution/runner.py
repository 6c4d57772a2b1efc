"""Runner of a plan: it stores blocks, replays and logs in the order of the plan, whatever executor plays them."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Final

from catch_arena.errors import ConfigError, DamagedStoreError
from catch_arena.files import prepare_folder, unwritable, write_whole
from catch_arena.policy import Side
from catch_arena.tournament.agent_spec import folder_of
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution.block_queue import ForfeitStreaks, play_blocks
from catch_arena.tournament.execution.executors import Executor, Worker
from catch_arena.tournament.export import write_standings
from catch_arena.tournament.match import MAX_FORFEITS, Block, PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import Plan
from catch_arena.tournament.secret import Secret
from catch_arena.tournament.statistics.standings import Standing, standings_of_sides
from catch_arena.tournament.store import Store, Tournament, terms_of

REPLAYS: Final = "replays"
LOGS: Final = "logs"
MOST_BYTES: Final = 4 << 20
"""Size of an agent's log file [bytes] from which on no match is added; the last one may exceed it."""
_LONGEST: Final = 240
"""Largest length of a file's name [bytes], without its ending."""


@dataclass(frozen=True, slots=True)
class Setup:
    """Setup of a tournament in a folder, as the commands `tournament` and `suite` play it."""

    folder: Path
    plan: Plan
    worker: Worker
    secret: Secret
    max_forfeits: int = MAX_FORFEITS
    """Number of forfeits in a row that exclude an entrant; 0 for no limit."""

    @property
    def tournament(self) -> Tournament:
        """Facts of the tournament, which its store has."""
        worker = self.worker
        terms = terms_of(worker.quotas, self.max_forfeits, recorded=worker.record)
        return Tournament(worker.config, worker.entrants, self.plan.parameters, self.secret.text, terms)

    def begin(self, *, resume: bool) -> AbstractContextManager[Store]:
        """Make the folder, not in that of an agent, and open its store; without `resume` it must not have matches."""
        for entrant in self.worker.entrants:
            own = folder_of(entrant.spec)
            if own is not None and self.folder.resolve().is_relative_to(own.resolve()):
                why = f"lies in the folder of agent {entrant.name}, which sees all files there"
                raise ConfigError(f"{self.folder}: {why}; choose another folder")
        prepare_folder(self.folder / REPLAYS if self.worker.record else self.folder)
        return Store.begin(self.tournament, self.folder, resume=resume)

    def play(
        self, store: Store, executor: Executor, progress: Callable[[int, int], None]
    ) -> dict[Side, list[Standing]]:
        """Play the matches that are not in the store yet, write the standings, and return them; see `play_plan`."""
        play_plan(store, self.plan, executor, max_forfeits=self.max_forfeits, progress=progress)
        played, parties = list(store.played()), Parties.of(self.worker.config)
        tables = standings_of_sides(self.worker.entrants, played, parties)
        write_standings(self.folder, self.tournament, len(played), tables)
        return tables


def play_plan(
    store: Store,
    plan: Plan,
    executor: Executor,
    *,
    max_forfeits: int = 0,
    progress: Callable[[int, int], None] = lambda *_: None,
) -> None:
    """Play the matches of a plan that are not in the store yet, stage by stage, to the end of the plan.

    A block is written when it and all earlier blocks have ended; agents' logs, and replays if the executor's worker
    makes them, are written to the store's folder. So the store has the first blocks of the plan, and the same call
    continues after them if it was interrupted; no process is left. `progress` is called with (matches played, matches
    of the plan) at the beginning and after each block.

    A block that failed on our side three times raises MatchFailedError, and stored matches that are not those of the
    plan raise StoreError.
    """
    streaks = ForfeitStreaks(max_forfeits)
    before = list(store.played())
    streaks.add(before)
    progress(len(before), plan.size)
    store.set_planned(plan.size)
    passed, played = 0, len(before)  # numbers of matches: of the plan's blocks so far, and of those in the store

    def without_stored(blocks: Iterable[Block]) -> Iterator[Block]:
        nonlocal passed
        for block in blocks:
            stored = before[passed : passed + len(block)]
            passed += len(block)
            if not stored:
                yield block
            elif tuple(one.match for one in stored) != block:
                raise DamagedStoreError(
                    f"{store.path}: is damaged: table match, row {block[0].id}: its block is not that of the plan"
                )

    for blocks in plan.stages(lambda: islice(store.played(), passed)):
        for results in play_and_store(store, without_stored(blocks), executor, streaks):
            played += len(results)
            progress(played, plan.size)
    store.end()


def play_and_store(
    store: Store, blocks: Iterable[Block], executor: Executor, streaks: ForfeitStreaks
) -> Iterator[list[PlayedMatch]]:
    """Play blocks, write them in this order, and yield the matches of each; raises the errors of `play_plan`."""
    tournament, folder = store.tournament, store.path.parent
    parties = Parties.of(tournament.config)
    for recorded in play_blocks(blocks, executor, streaks):
        for one, replay in recorded:  # files first, so that every match in the store has its files
            if replay:
                write_whole(prepare_folder(folder / REPLAYS) / f"{one.match.id}.replay", replay)
            add_to_logs(folder / LOGS, tournament.entrants, parties, one)
        played = [one for one, _ in recorded]
        store.add(played)
        yield played


def add_to_logs(folder: Path, entrants: Sequence[Entrant], parties: Parties, one: PlayedMatch) -> None:
    """Add the output and the fault of each party of a match to its log; the folder is made when it is needed."""
    for party, index in enumerate(one.match.seating):
        forfeit, printed = one.result.forfeits[party], one.result.logs[party]
        if forfeit is None and not printed:
            continue
        why = f": {forfeit}" if forfeit is not None else ""
        text = f"== match {one.match.id}, {parties.called(party)}{why}\n{printed}".removesuffix("\n")
        path = log_file(folder, entrants[index].name)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("ab") as file:
                if file.tell() < MOST_BYTES:
                    file.write(f"{text}\n".encode())
        except OSError as error:
            raise unwritable(path, error) from None


def log_file(folder: Path, name: str) -> Path:
    """Return the log file of an entrant."""
    *folders, last = name.split("/")  # a name may be ann/agent
    return Path(folder, *folders, f"{last.encode()[:_LONGEST].decode(errors='ignore')}.log")
