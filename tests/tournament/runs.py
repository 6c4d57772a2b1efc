"""Functions that play a whole plan without a store on disk, and that export a store."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from catch_arena.config import ArenaConfig
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution.executors import Worker, local_executor
from catch_arena.tournament.execution.runner import play_plan
from catch_arena.tournament.export import export
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.match import PlayedMatch
from catch_arena.tournament.plans.schedule import Plan
from catch_arena.tournament.store import Store, Tournament


@contextmanager
def new_store(tournament: Tournament, folder: Path | None = None) -> Iterator[Store]:
    """Return a new store in this folder, or in a temporary one."""
    with TemporaryDirectory() as temporary, Store.begin(tournament, folder or Path(temporary)) as store:
        yield store


def run(
    config: ArenaConfig,
    entrants: Sequence[Entrant],
    plan: Plan,
    *,
    jobs: int = 1,
    quotas: Quotas | None = None,
    max_forfeits: int = 0,
    record: Path | None = None,
) -> list[PlayedMatch]:
    """Return every match of a plan, played, in the plan's order; `record` is the folder of the store and replays."""
    worker = Worker(config, tuple(entrants), record=record is not None, quotas=quotas)
    with (
        new_store(Tournament(config, tuple(entrants), plan.parameters, "0"), record) as store,
        local_executor(worker, jobs) as executor,
    ):
        play_plan(store, plan, executor, max_forfeits=max_forfeits)
        return list(store.played())


def exported(folder: Path) -> bytes:
    """Return all matches in a folder's store, without their times."""
    with Store.read(folder) as store:
        export(store, folder / "matches.jsonl", timing=False)
    return (folder / "matches.jsonl").read_bytes()
