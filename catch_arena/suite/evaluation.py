"""Play of a suite by an agent: each scenario is a tournament of its own, kept in the agent's folder."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from catch_arena.errors import StoreError
from catch_arena.files import prepare_folder
from catch_arena.suite.contents import Suite, SuiteScenario
from catch_arena.tournament.entrants import Entrant, enter
from catch_arena.tournament.execution.executors import Worker, local_executor
from catch_arena.tournament.execution.runner import play_plan
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match import MAX_FORFEITS, PlayedMatch
from catch_arena.tournament.match_loop import play_entrants
from catch_arena.tournament.plans.schedule import Plan
from catch_arena.tournament.store import STORE, Store, Tournament, terms_of

_enter_once = cache(enter)


@dataclass(frozen=True, slots=True)
class Evaluation:
    """One agent in a suite, and the terms on which it plays."""

    suite: Suite
    agent: Entrant
    out: Path
    """Folder of the matches of all agents."""
    blocks: int
    """Number of blocks of each scenario: as many as the suite has, or fewer for a first look."""
    quotas: Quotas | None
    """Quotas of an isolated agent; None for a trusted one."""

    @property
    def folder(self) -> Path:
        """Folder of the agent's matches, with a folder for each scenario that contains the store of a tournament.

        Its name is that of the agent, with `/` and `..` replaced so that it is one folder.
        """
        return self.out / self.agent.name.replace("/", "-").replace("..", "__")

    @property
    def matches(self) -> int:
        """Number of matches in all scenarios."""
        return sum(self._plan(one).size for one in self.suite.scenarios)

    def entrants(self, scenario: SuiteScenario) -> tuple[Entrant, ...]:
        """Return the agent and its opponents in the plan's order; an opponent of its name is called `nearest#2`."""
        opponents = _enter_once(scenario.opponents)
        return self.agent, *(replace(one, name=one.name + "#2" * (one.name == self.agent.name)) for one in opponents)

    def require_new(self) -> None:
        """Check that no scenario's folder holds matches yet.

        Raises:
            StoreError: if matches are kept already.
        """
        for one in self.suite.scenarios:
            if (self._folder(one) / STORE).exists():
                raise StoreError(
                    f"{self.folder}: already contains matches of {self.agent.name}; "
                    "continue with --resume, or choose another folder"
                )

    def cannot_play(self, sandbox: Sandbox | None) -> Iterator[tuple[str, str]]:
        """Yield the scenarios in which the agent fails at its first observation, and the reasons; no match is kept.

        An observation may be wider or narrower than in other arenas. `idle` plays all other parties.

        Args:
            sandbox: the sandbox of an agent that is not trusted; None for a trusted one.
        """
        if self.agent.fault is not None:
            yield "any scenario", self.agent.fault
            return
        (idle,) = enter(["idle"])
        for one in self.suite.scenarios:
            entrants = [self.agent] + [idle] * (len(one.parties) - 1)
            result = play_entrants(one.config, self.suite.seed, entrants, sandbox, most_steps=1)
            if (forfeit := result.forfeits[0]) is not None:
                yield one.name, forfeit.reason

    def play(self, jobs: int, progress: Callable[[int, int], None] = lambda *_: None) -> None:
        """Play the matches that are not kept yet, scenario by scenario.

        Args:
            jobs: number of processes.
            progress: called with (matches played, matches of all scenarios) at the beginning and after each block.

        Raises:
            OtherTournamentError: for matches in the folder that are of another agent, or on other terms.
            MatchFailedError, OutputError: see `play_plan`.
        """
        waiting, done = [], 0
        for one in self.suite.scenarios:
            with self._store(one):  # checks all folders first: their matches must be this agent's
                kept = self.played(one)
            if len(kept) < self._plan(one).size:
                waiting.append(one)
            else:
                done += len(kept)
        progress(done, self.matches)

        def show(played: int, _: int) -> None:
            progress(done + played, self.matches)

        with local_executor(self._worker(self.suite.scenarios[0]), jobs) as ready:
            for one in waiting:
                ready.worker, plan = self._worker(one), self._plan(one)
                with self._store(one) as store:
                    play_plan(store, plan, ready, max_forfeits=MAX_FORFEITS, progress=show)
                done += plan.size

    def played(self, scenario: SuiteScenario) -> list[PlayedMatch]:
        """Return the kept matches of a scenario that belong to the first `blocks` blocks; the store may have more."""
        folder = self._folder(scenario)
        if not (folder / STORE).is_file():
            return []
        with Store.read(folder) as store:
            return [one for one in store.played() if one.match.block < self.blocks]

    def _store(self, scenario: SuiteScenario) -> AbstractContextManager[Store]:
        """Open the store of a scenario, or create it if there is none.

        Raises:
            OtherTournamentError: for a store of another agent, or on other terms.
        """
        terms = terms_of(self.quotas, MAX_FORFEITS, recorded=False)
        parameters, secret = self._plan(scenario).parameters, self.suite.secret(scenario)
        facts = Tournament(scenario.config, self.entrants(scenario), parameters, secret.text, terms)
        return Store.begin(facts, prepare_folder(self._folder(scenario)), resume=True)

    def _plan(self, scenario: SuiteScenario) -> Plan:
        return self.suite.plan(scenario, self.blocks)

    def _worker(self, scenario: SuiteScenario) -> Worker:
        return Worker(scenario.config, self.entrants(scenario), quotas=self.quotas)

    def _folder(self, scenario: SuiteScenario) -> Path:
        return self.folder / scenario.name
