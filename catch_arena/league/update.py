"""One run of a league: find what is new, check it, play until each entry has its place, and remove what is old."""

import math
import shutil
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from contextlib import AbstractContextManager, ExitStack, suppress
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import cached_property, partial
from itertools import groupby
from pathlib import Path
from typing import Final

from catch_arena.classroom.similarity import similar_pairs
from catch_arena.classroom.submissions import STATE
from catch_arena.config import ArenaConfig
from catch_arena.errors import AgentError, ConfigError, MatchFailedError
from catch_arena.files import prepare_folder, write_whole
from catch_arena.league.entries import Entry, entrant_name, find_entries, shipped_entries, with_own_names
from catch_arena.league.kept_matches import Part, matches_kept
from catch_arena.league.matchmaking import Evidence, next_blocks, weigh
from catch_arena.league.store import LeagueStore, RatingThen, Version
from catch_arena.text import one_line, without_folders
from catch_arena.tournament.agent_check import check_fitness
from catch_arena.tournament.agent_spec import is_shipped
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution.block_queue import ForfeitStreaks, do_in_order
from catch_arena.tournament.execution.executors import Executor, Worker, local_executor
from catch_arena.tournament.execution.runner import LOGS, REPLAYS, log_file, play_and_store
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.match import MAX_FORFEITS, PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import block_of
from catch_arena.tournament.players import enter
from catch_arena.tournament.secret import Secret
from catch_arena.tournament.statistics.intervals import FEWEST_BLOCKS
from catch_arena.tournament.store import Store, Tournament, terms_of

_COPIES: Final = "versions"
_MATCHES_KEPT: Final = 20_000
"""Number of the newest matches that are kept; the ratings follow from them."""
_LOG_KEPT: Final = 200_000
"""Part of a log that stays after a run, from its end [bytes]."""


@dataclass(frozen=True, slots=True)
class Rules:
    """Rules of a league."""

    config: ArenaConfig
    scenario: str
    """Name of the arena."""
    quotas: Quotas
    precision: float
    """Largest half width of a rating's interval with which an entrant has its place in any case [points]."""
    max_matches: int
    """Largest number of matches of a version until it has its place."""
    secret_opponents: Path | None
    """Folder of further opponents, whose names are not shown."""


@dataclass
class League:
    """A league in a run, and after it."""

    folder: Path
    rules: Rules
    entries: Sequence[Entry]
    """Present entries: agents that come with the package, secret opponents, and persons."""
    versions: Mapping[str, Sequence[Version]]
    """Versions of each entry, by its key, the oldest first; also of entries that are gone."""
    entrants: Sequence[Entrant]
    played: list[PlayedMatch]
    """Matches that are kept, in the order of the plan."""
    ratings: Sequence[RatingThen]
    """Ratings after each run, in the order of time."""
    evidence: Evidence = field(default_factory=Evidence)
    """Evidence of the matches so far about the present entrants."""
    new_matches: int = 0
    """Number of matches that this run played."""

    def __post_init__(self) -> None:
        self.parties = Parties.of(self.rules.config)
        self.streaks = ForfeitStreaks(MAX_FORFEITS)
        """Versions that play no more, since they forfeited too many matches in a row."""
        self.streaks.add(self.played)

    @property
    def state(self) -> Path:
        """Folder of the league's own files."""
        return self.folder / STATE

    @cached_property
    def current(self) -> Mapping[str, int]:
        """Entrant that plays for each present entry, by its key; an entry has none until a version passes the check.

        It is that of the present files, or of the newest version whose files are kept.
        """
        playing = {}
        for entry in self.entries:
            able = {
                one.digest: one.entrant
                for one in self.versions.get(entry.key, ())
                if one.entrant is not None
                and (entry.submission is None or (self.state / _COPIES / one.digest).exists())
            }
            if able:
                playing[entry.key] = able.get(entry.digest, [*able.values()][-1])
        return playing

    @cached_property
    def persons(self) -> frozenset[int]:
        """Entrants that play for persons."""
        return frozenset(
            self.current[one.key] for one in self.entries if one.kind == "person" and one.key in self.current
        )

    @cached_property
    def numbers(self) -> Mapping[str, int]:
        """Number of each entry, from 1, in the order in which the entries came: the names of their pages."""
        came = sorted(self.versions, key=lambda key: (self.versions[key][0].entered, key))
        return {key: number for number, key in enumerate(came, 1)}

    @cached_property
    def parts(self) -> Mapping[int, Sequence[Part]]:
        """Matches of each entrant, in the order of the plan; for use after the run."""
        found: dict[int, list[Part]] = defaultdict(list)
        for one in self.played:
            for party, index in enumerate(one.match.seating):
                found[index].append(Part(one, party))
        return found

    def is_placed(self, entrant: int) -> bool:
        """Return whether a rating is precise enough by the rules, or its interval has no other rating."""
        ratings = self.evidence.ratings
        rating = ratings.get(entrant)
        if rating is None or math.isnan(rating.low):
            return False
        within = [one for one in ratings.values() if rating.low <= one.mean <= rating.high]
        return rating.margin <= self.rules.precision or len(within) == 1

    def is_waiting(self, entrant: int) -> bool:
        """Return whether an entrant plays further matches until it has its place."""
        matches = self.evidence.blocks.get(entrant, 0) * self.parties.block_size
        return entrant not in self.streaks.excluded and not self.is_placed(entrant) and matches < self.rules.max_matches


def update_league(
    folder: Path,
    rules: Rules,
    jobs: int,
    executor_of: Callable[[Worker], Executor],
    *,
    now: datetime,
    secret: Secret | None,
    report: Callable[[str], None],
    on_progress: Callable[[int, int], None],
) -> League:
    """Run a league once, and return it.

    Args:
        folder: has a file or sub-folder for each person.
        rules: the arena and the quotas must be those of the runs before.
        jobs: number of processes that check new versions.
        executor_of: makes the executor that plays the matches.
        now: time of the run, with its time zone.
        secret: source of all seeds; None to draw it for a new league, or to keep that of the runs before.
        report: called with each piece of news, in one line.
        on_progress: called with the number of matches played so far, and about the number of all.
    """
    parties = Parties.of(rules.config)
    if parties.group < 2:
        raise ConfigError(f"scenario must have two parties that compete, got {rules.scenario}")
    entries = find_entries(folder, "person", report, rules.secret_opponents)
    if not entries:
        raise ConfigError(f"{folder}: has no entry; it needs a .py file or a sub-folder for each person")
    if rules.secret_opponents is not None:
        entries = [*find_entries(rules.secret_opponents, "secret", report), *entries]
    entries = with_own_names([*shipped_entries(parties.group), *entries])
    with _opened(folder, rules, secret) as store:
        time = store.time_after(now)
        _add_versions(store, rules, entries, jobs, time, report)
        versions = {key: [*found] for key, found in groupby(store.versions(), lambda version: version.entry)}
        entrants = store.tournament.entrants
        league = League(folder, rules, entries, versions, entrants, [*store.played()], store.ratings())
        _play(store, league, executor_of, on_progress)
        ratings = _ratings(league, time)
        if ratings != [replace(one, time=time) for one in league.ratings if one.time == league.ratings[-1].time]:
            store.add_ratings(ratings)  # also if a run before was killed after its matches
            league.ratings = store.ratings()
        _remove_old(store, league)
        return league


def _opened(folder: Path, rules: Rules, secret: Secret | None) -> AbstractContextManager[LeagueStore]:
    """Open the store of a league; a new league gets one. No other run can open it meanwhile."""
    state = prepare_folder(folder / STATE)
    with suppress(OSError):  # a file system without permissions
        state.chmod(0o700)  # copies of private files, and logs
    before = Store.tournament_in(state)
    secret = secret or (before.secret if before else Secret.of(None))
    terms = terms_of(rules.quotas, MAX_FORFEITS, recorded=True)
    entrants = before.entrants if before else ()
    about = Tournament(rules.config, entrants, {"format": "league"}, secret.text, terms)
    return LeagueStore.begin(about, state, resume=True)


def _add_versions(
    store: LeagueStore,
    rules: Rules,
    entries: Sequence[Entry],
    jobs: int,
    time: str,
    report: Callable[[str], None],
) -> None:
    """Check new and changed entries, and write the version of each as soon as it is checked."""
    known = store.versions()
    before = {(one.entry, one.digest): one.entrant for one in known}
    new = {one.key for one in entries if (one.key, one.digest) not in before}
    copies = prepare_folder(store.path.parent / _COPIES)
    agents: dict[str, str] = {}
    for entry in entries:
        # a person may have gone back to an old version
        if entry.key in new or before[entry.key, entry.digest] is not None:
            try:
                agents[entry.key] = entry.copy_to(copies)
            except ConfigError as error:
                report(f"{entry.key}: {error}")
    checked_now = [entry for entry in entries if entry.key in new and entry.key in agents]
    if not checked_now:
        return
    for pair in similar_pairs([one.submission for one in entries if one.kind == "person" and one.submission]):
        if {pair.first, pair.second} & new:
            report(f"look at these two: {pair.first} and {pair.second}: {pair}")
    worker = Worker(rules.config, (), quotas=rules.quotas)
    entrants = [*store.tournament.entrants]
    with local_executor(worker, min(jobs, len(checked_now))) as executor:

        def begin(entry: Entry) -> Future[Entrant]:
            return executor.run(check_version, worker, agents[entry.key], rules.scenario, entry.fault)

        for entry, checked in do_in_order(checked_now, executor, begin):
            if isinstance(checked, MatchFailedError):
                report(f"{entry.key}: could not be checked: {checked}; the next run tries again")
                continue
            number = 1 + sum(one.entry == entry.key for one in known)
            index = None if checked.fault else len(entrants)
            if index is not None:
                entrants.append(replace(checked, name=entrant_name(entry, number, entrants)))
            version = Version(entry.key, number, entry.digest, time, index, checked.fault or "", checked.log)
            store.add_version(version, entrants)
            if entry.kind != "shipped":
                result = f"does not pass the check: {checked.fault}" if index is None else "enters"
                report(f"{entry.key}: version {number} {result}")


def check_version(worker: Worker, agent: str, scenario: str, fault: str) -> Entrant:
    """Return the entrant of a new version, which has a fault if it does not pass the check.

    It is inspected, and plays against itself if it does not come with the package. If its files cannot be used,
    `fault` has the reason.

    Raises:
        MatchFailedError: if it could not be checked, for a reason on our side.
    """
    if fault:
        return Entrant(agent, agent, "target", "", fault)
    try:
        (entrant,) = enter([agent], worker.sandbox)
        if not is_shipped(entrant.spec):
            for finding in check_fitness(entrant, {scenario: worker.config}, worker.sandbox):
                if finding.level == "error":
                    fault, _, log = finding.text.partition("\n")
                    return replace(entrant, fault=_without_copies(fault, entrant.spec), log=log)
    except AgentError as error:
        return Entrant(agent, agent, "target", "", _without_copies(str(error), agent))
    except OSError as error:
        raise MatchFailedError(str(error)) from None
    finally:
        worker.close()
    return entrant


def _without_copies(text: str, agent: str) -> str:
    """Return a text without the path of the copy that an agent plays from."""
    return one_line(without_folders(text.replace(f"{agent}: ", "")))


def _play(
    store: LeagueStore,
    league: League,
    executor_of: Callable[[Worker], Executor],
    on_progress: Callable[[int, int], None],
) -> None:
    """Play until no present entry waits for its place."""
    secret, parties, rules = store.tournament.secret, league.parties, league.rules
    playing = {*league.current.values()}
    able = tuple(
        replace(one, spec=_present_path(one.spec, league.folder)) if index in playing else replace(one, fault="is old")
        for index, one in enumerate(league.entrants)
    )
    before, (rounds, first) = len(league.played), store.next_block()
    number = first
    zero = league.current.get(league.entries[0].key, -1)
    executor: Executor | None = None
    with ExitStack() as stack:
        while True:
            pool = sorted(playing - {*league.streaks.excluded})
            league.evidence = weigh(league.played, parties, zero, playing)
            league.new_matches = len(league.played) - before
            waiting = sorted(
                filter(league.is_waiting, league.persons & {*pool}),
                key=lambda index: league.evidence.blocks.get(index, 0),
            )
            on_progress(league.new_matches, league.new_matches + _matches_left(league, waiting))
            if not waiting or len(pool) < parties.group:
                return
            if executor is None:
                executor = stack.enter_context(executor_of(Worker(rules.config, able, True, rules.quotas)))
            draw = partial(secret.part("groups", number).seed, "groups")
            groups = next_blocks(waiting, pool, league.evidence, parties.group, draw)
            blocks = [
                block_of(players, secret, block, f"r{rounds + 1:05d}-g{block - first + 1:06d}", parties)
                for block, players in enumerate(groups, number)
            ]
            number += len(groups)
            for results in play_and_store(store, blocks, executor, league.streaks):
                league.played.extend(results)


def _present_path(spec: str, folder: Path) -> str:
    """Return the spec of a copied version in the league's folder, which may have been moved since the version came."""
    _, found, copy = spec.partition(f"/{STATE}/{_COPIES}/")
    return str(folder.absolute() / STATE / _COPIES / copy) if found else spec


def _matches_left(league: League, waiting: Sequence[int]) -> int:
    """Return about how many matches are left: an interval's width falls with the root of the number of blocks."""
    size, left = league.parties.block_size, 0.0
    for index in waiting:
        blocks, rating = league.evidence.blocks.get(index, 0), league.evidence.ratings.get(index)
        margin = 0.0 if rating is None or math.isnan(rating.margin) else rating.margin
        needed = max(FEWEST_BLOCKS, blocks * (margin / league.rules.precision) ** 2)
        left += max(1.0, min(needed, league.rules.max_matches / size) - blocks)
    return math.ceil(left / league.parties.group) * size


def _ratings(league: League, time: str) -> list[RatingThen]:
    """Return the ratings of the present entrants, in the order of the store."""
    found = league.evidence.ratings
    order = sorted(league.persons & {*found}, key=lambda index: -found[index].mean)
    places = {index: place for place, index in enumerate(order, 1)}
    return [
        RatingThen(
            index, time, places.get(index), one.mean, *(None if math.isnan(end) else end for end in (one.low, one.high))
        )
        for index, one in sorted(found.items())
    ]


def _remove_old(store: LeagueStore, league: League) -> None:
    """Remove old matches, replays that no page shows, and the files of old versions."""
    store.remove_old(_MATCHES_KEPT)
    playing = {*league.current.values()}
    kept = {match for index in playing for match in matches_kept(league.parts.get(index, ()), league.parties)}
    logs = {log_file(league.state / LOGS, league.entrants[index].name) for index in playing}
    digests = {one.digest for versions in league.versions.values() for one in versions if one.entrant in playing}
    old = [path for path in (league.state / REPLAYS).glob("*.replay") if path.stem not in kept]
    old += [path for path in (league.state / LOGS).rglob("*.log") if path not in logs]
    with suppress(OSError):  # what cannot be removed stays
        for path in old:
            path.unlink(missing_ok=True)
        for path in logs:
            if path.exists() and path.stat().st_size > _LOG_KEPT:
                write_whole(path, path.read_bytes()[-_LOG_KEPT:])
    for path in (league.state / _COPIES).glob("*"):
        if path.name not in digests:
            shutil.rmtree(path, ignore_errors=True)
