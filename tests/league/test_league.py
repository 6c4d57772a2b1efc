"""A league runs from a folder: versions are checked and placed, pages show each person, and nothing is lost."""

import errno
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from dataclasses import replace
from datetime import datetime, timedelta, timezone
from itertools import combinations
from pathlib import Path
from types import SimpleNamespace

import pytest
from command_line import run
from tournament.agents import source
from tournament.runs import run as play

from catch_arena.cli import league as league_command
from catch_arena.errors import StoreError
from catch_arena.league import site, update
from catch_arena.league.entries import shipped_entries
from catch_arena.league.kept_matches import Part, best_and_worst
from catch_arena.league.matchmaking import Evidence, next_blocks, weigh
from catch_arena.league.store import LeagueStore, RatingThen
from catch_arena.scenarios import scenario
from catch_arena.tournament.execution import block_queue
from catch_arena.tournament.match import Forfeit
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.players import enter
from catch_arena.tournament.statistics.intervals import Estimate
from catch_arena.tournament.statistics.outcomes import SideResults
from catch_arena.tournament.statistics.standings import standings
from catch_arena.tournament.store import Store, only_one_plays_in

ARENA = ["-s", "duel", "--set", "time_limit_s=3", "--limit", "isolation=processes", "--jobs", "1", "--seed", "5"]
SHORT = [*ARENA, "--precision", "400", "--max-matches", "20"]


def agent(act="return 1 if view.targets else 0", **parts):
    return source(act, **parts)


def entries(made):
    """A folder with two entries."""
    for name, content in {
        "ann": agent(reset="print('ann began with', seed)"),
        "bob": agent("return len(view.targets)"),
    }.items():
        (made / name).mkdir(parents=True)
        (made / name / "agent.py").write_text(content)
    return made


@pytest.fixture(scope="module")
def played_league(tmp_path_factory):
    made = entries(tmp_path_factory.mktemp("league") / "robots")
    done = league(made)
    assert done.exit_code == 0, done.output
    return made


@pytest.fixture
def folder(tmp_path):
    """Two entries that have not played yet."""
    return entries(tmp_path / "robots")


@pytest.fixture
def ran(tmp_path, played_league):
    """A league of these two after its first run, which was moved to another folder."""
    return Path(shutil.copytree(played_league, tmp_path / "robots"))


def league(folder, *words):
    return run("league", folder, *SHORT, *words, columns=500)


def matches(folder):
    with sqlite3.connect(folder / ".league" / "tournament.sqlite") as db:
        return dict(db.execute("SELECT id, json_extract(played, '$.result.digest') FROM match"))


def page_of(folder, name):
    """The page of a person."""
    pages = [path.read_text() for path in (folder / "site").glob("person_*.html")]
    return next(page for page in pages if f"<title>{name} · robots</title>" in page)


def test_a_league_places_each_entry_and_a_second_run_plays_nothing(folder):
    first = league(folder)
    assert first.exit_code == 0, first.output
    assert "ann: version 1 enters" in first.output
    table = (folder / "site" / "index.html").read_text()
    assert re.search(r'<a href="person_\d.html">ann</a>', table)
    assert "comes with Catch Arena" in table
    played = matches(folder)
    assert len(played) >= 4
    second = league(folder)
    assert "0 new matches" in second.output
    assert "enters" not in second.output
    assert matches(folder) == played
    assert (folder / "site" / "index.html").read_text() == table


def test_the_same_seed_and_entries_give_the_same_league_with_any_number_of_jobs(folder, tmp_path):
    league(folder)
    other = tmp_path / "again" / "robots"
    other.parent.mkdir()
    for name in ("ann", "bob"):
        (other / name).mkdir(parents=True)
        (other / name / "agent.py").write_text((folder / name / "agent.py").read_text())
    league(other, "--jobs", "2")
    assert matches(other) == matches(folder)


def test_a_changed_agent_enters_as_a_new_version_and_the_old_one_plays_no_more(ran):
    before = matches(ran)
    (ran / "bob" / "agent.py").write_text(agent("return 0"))
    changed = league(ran)
    assert "bob: version 2 enters" in changed.output
    assert "ann: version" not in changed.output
    assert before.items() <= matches(ran).items()
    with Store.read(ran / ".league") as store:
        names = [one.name for one in store.tournament.entrants]
        new = [one for one in store.played() if one.match.id not in before]
    assert {name for one in new for name in (names[index] for index in one.match.seating)} >= {"bob v2"}
    assert all(names[index] != "bob" for one in new for index in one.match.seating)
    page = page_of(ran, "bob")
    assert page.count('<tr><th scope="row">2</th>') == page.count('<tr><th scope="row">1</th>') == 1
    (ran / "bob" / "agent.py").write_text(agent("return len(view.targets)"))
    assert "bob: version" not in league(ran).output  # its first version plays again


def test_bad_entries_cost_only_themselves(folder):
    (folder / "syntax.py").write_text("class Agent(:")
    (folder / "crash.py").write_text(agent("return 1 / 0"))
    (folder / "hang").mkdir()
    (folder / "hang" / "agent.py").write_text(agent("while True: pass"))
    (folder / "flood.py").write_text(agent("print('x' * 100_000); return 0"))
    shutil.copytree(folder / "ann", folder / "copy")
    (folder / "book.ipynb").write_text("{}")
    (folder / "linked").mkdir()
    (folder / "linked" / "agent.py").symlink_to(folder / "ann" / "agent.py")
    (folder / "twice").mkdir()
    (folder / "twice" / "agent.py").write_text(agent())
    (folder / "twice.py").write_text(agent())
    (folder / "README.md").write_text("no entry")
    done = league(folder, "--limit", "step_ms=1000", "--limit", "bank_s=5")
    assert done.exit_code == 0, done.output
    for line in (
        "syntax: version 1 does not pass the check: cannot begin",
        "crash: version 1 does not pass the check: duel: FORFEIT_CRASH in step 1: act raised ZeroDivisionError",
        "hang: version 1 does not pass the check: duel: FORFEIT_TIMEOUT in step 1",
        "flood: version 1 enters",
        "book: version 1 does not pass the check",
        "linked: version 1 does not pass the check: it has no file that can be read; links are not followed",
        "twice: version 1 does not pass the check: twice and twice.py have one name; rename one of them",
        "look at these two: ann and copy: equal files",
    ):
        assert line in done.output
    page = page_of(folder, "crash")
    assert "ZeroDivisionError" in page
    assert "return 1 / 0" not in page  # a line of source in the traceback
    assert str(folder) not in page
    assert (folder / ".league").stat().st_mode & 0o077 == 0


def test_the_site_shows_no_seed_no_source_and_no_log_of_others(folder):
    (folder / "bob" / "agent.py").write_text(agent(reset="print('log of bob')", before="SOURCE_OF_BOB = 1"))
    league(folder)
    with Store.read(folder / ".league") as store:
        seeds = {str(one.match.seed) for one in store.played()} | {
            store.tournament.seed,
            store.tournament.secret.digits,
        }
    for path in (folder / "site").iterdir():
        page = path.read_text()
        assert "SOURCE_OF_BOB" not in page
        assert not any(seed in page for seed in seeds - {"5"})
        assert ("log of bob" in page) == ("<title>bob ·" in page)
        assert str(folder.parent) not in page


def test_names_and_photos_are_optional_and_are_no_new_version(ran):
    (ran / "ann" / "name.txt").write_text("Ann <the first>\n")
    (ran / "ann" / "photo.png").write_bytes(b"\x89PNG and so on")
    assert "enters" not in league(ran).output
    table = (ran / "site" / "index.html").read_text()
    assert "Ann &lt;the first&gt;" in table
    assert "data:image/png;base64," in table
    (ran / "bob" / "name.txt").write_text("../../bob")
    (ran / "ann" / "photo.png").write_bytes(bytes(200_001))
    done = league(ran)
    assert "warning: bob: name.txt: its name must have no /, got '../../bob'" in done.output
    assert "warning: ann: photo.png must have at most 200 kB" in done.output
    table = (ran / "site" / "index.html").read_text()
    assert ">bob<" in table
    assert "Ann &lt;the first&gt;" in table


def test_a_name_that_another_entry_has_gets_a_number(ran):
    (ran / "bob" / "name.txt").write_text("nearest")
    league(ran)
    assert ">nearest (2)</a>" in (ran / "site" / "index.html").read_text()


def test_files_that_cannot_be_used_leave_the_version_before_in_play(ran):
    replays = sorted(path.name for path in (ran / ".league" / "replays").iterdir())
    (ran / "bob" / "agent.py").rename(ran / "away.txt")
    done = league(ran)
    assert "bob: version 2 does not pass the check: it has no file that can be read" in done.output
    assert "0 new matches" in done.output
    page = page_of(ran, "bob")
    assert "Version 2 did not pass the check" in page
    assert "Version 1 goes on playing." in page
    assert page.count("<catch-replay id=") == 2
    assert sorted(path.name for path in (ran / ".league" / "replays").iterdir()) == replays
    (ran / "away.txt").rename(ran / "bob" / "agent.py")
    assert "0 new matches" in league(ran).output
    assert "did not pass the check" not in page_of(ran, "bob")


def test_after_a_bad_version_the_one_that_played_before_it_goes_on_though_it_is_older(ran):
    """Only its files are kept: those of the second version went when the person took that back."""
    first = (ran / "bob" / "agent.py").read_text()
    for text in (agent("return 0"), first, "class Agent(:"):
        (ran / "bob" / "agent.py").write_text(text)
        done = league(ran)
    assert "bob: version 3 does not pass the check" in done.output
    assert "0 new matches" in done.output
    page = page_of(ran, "bob")
    assert "Version 1 goes on playing." in page
    assert "FORFEIT_INIT" not in page


def test_an_agent_with_a_package_plays_from_its_copy(ran):
    (ran / "cid" / "tools").mkdir(parents=True)
    (ran / "cid" / "tools" / "__init__.py").write_text("FIRST = 1")
    (ran / "cid" / "agent.py").write_text("from tools import FIRST\n" + agent("return FIRST if view.targets else 0"))
    assert "cid: version 1 enters" in league(ran).output


@pytest.mark.parametrize("failures", [1, 2, 3])
def test_a_check_that_fails_on_our_side_is_made_again_three_times_and_then_in_the_next_run(ran, monkeypatch, failures):
    monkeypatch.setattr(block_queue, "_PAUSE_S", 0.0)
    (ran / "cid.py").write_text(agent("return 0  # cid"))
    left, check = list(range(failures)), update.check_fitness

    def fail(*arguments):
        if left:
            left.pop()
            raise OSError("the disk is full")
        return check(*arguments)

    monkeypatch.setattr(update, "check_fitness", fail)
    done = league(ran)
    assert done.exit_code == 0, done.output
    enters = "cid: version 1 enters"
    if failures == 3:
        assert "cid: could not be checked: the disk is full; the next run tries again" in done.output
        assert enters not in done.output
        done = league(ran)
    assert enters in done.output


def test_a_run_that_ends_during_its_checks_keeps_those_that_are_done(ran, monkeypatch):
    for name in ("cid", "dan"):
        (ran / f"{name}.py").write_text(agent(f"return 0  # {name}"))
    check = update.check_fitness

    def interrupt_at_dan(entrant, *rest):
        if entrant.name.startswith("dan"):
            raise KeyboardInterrupt
        return check(entrant, *rest)

    monkeypatch.setattr(update, "check_fitness", interrupt_at_dan)
    assert "cid: version 1 enters" in league(ran).output
    monkeypatch.undo()
    done = league(ran)
    assert "dan: version 1 enters" in done.output
    assert "cid: version" not in done.output
    assert ">cid<" in (ran / "site" / "index.html").read_text()


def enters_while_copying(ran, monkeypatch, copyfile):
    """The output of a run in which cid enters and files are copied by this function, and of the next run."""
    (ran / "cid.py").write_text(agent("return 0  # cid"))
    monkeypatch.setattr(shutil, "copyfile", copyfile)
    done = league(ran)
    assert done.exit_code == 0, done.output
    monkeypatch.undo()
    return done.output, league(ran).output


def test_files_that_change_while_they_are_copied_wait_for_the_next_run(ran, monkeypatch):
    copy = shutil.copyfile

    def change_and_copy(path, target):
        path.write_text(agent("return 1  # changed"))
        copy(path, target)

    first, second = enters_while_copying(ran, monkeypatch, change_and_copy)
    assert "cid: its files change; the next run takes them" in first
    assert "cid: version 1 enters" in second


def test_a_file_that_comes_while_others_are_copied_belongs_to_the_next_version(ran, monkeypatch):
    copy = shutil.copyfile

    def copy_and_add(path, target):
        copy(path, target)
        path.with_suffix(".txt").write_text("weights")

    first, second = enters_while_copying(ran, monkeypatch, copy_and_add)
    assert "cid: version 1 enters" in first
    assert "cid: version 2 enters" in second


def test_an_entry_called_site_is_refused(ran):
    (ran / "site" / "agent.py").write_text(agent())
    done = league(ran)
    assert done.exit_code == 2
    assert "site: is the folder of the pages; rename this entry" in done.output


def test_secret_opponents_play_and_are_not_named(folder, tmp_path):
    (tmp_path / "hidden").mkdir()
    (tmp_path / "hidden" / "teacher.py").write_text(agent())
    done = league(folder, "--secret-opponents", tmp_path / "hidden")
    assert done.exit_code == 0, done.output
    assert "secret opponent" in (folder / "site" / "index.html").read_text()
    assert not any("teacher" in path.read_text() for path in (folder / "site").iterdir())


def test_an_entry_that_is_gone_leaves_the_table(ran):
    for path in (ran / "bob" / "agent.py", ran / "bob"):
        path.unlink() if path.is_file() else path.rmdir()
    assert league(ran).exit_code == 0
    assert ">bob<" not in (ran / "site" / "index.html").read_text()
    assert len(list((ran / "site").glob("person_*.html"))) == 1


def test_a_killed_run_loses_no_match(ran):
    """The second run ends by SIGKILL after some of its matches; the third one goes on."""
    before = matches(ran)
    for name in ("cid", "dan", "eve"):
        (ran / f"{name}.py").write_text(agent(f"return 0  # {name}", reset=f"self.name = '{name}'"))
    words = [sys.executable, "-m", "catch_arena", "league", str(ran), *SHORT]
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        while process.poll() is None and len(matches(ran)) < len(before) + 4:
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
    kept = matches(ran)
    assert before.items() <= kept.items()
    done = league(ran)
    assert done.exit_code == 0, done.output
    assert kept.items() <= matches(ran).items()
    assert "0 new matches" in league(ran).output


def test_a_run_that_was_killed_before_it_wrote_its_store_does_not_block_the_next_one(folder):
    (folder / ".league").mkdir()
    (folder / ".league" / "tournament.sqlite").touch()
    assert league(folder).exit_code == 0


def test_two_runs_exclude_each_other(ran):
    with only_one_plays_in(ran / ".league"):
        done = league(ran)
    assert done.exit_code == 2
    assert "another command is playing in this folder" in done.output


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["--every", "15"], "--every must be a number with s, m, h or d, such as 15m, got '15'"),
        (["--every", "0m"], "--every must be a number with s, m, h or d, such as 15m, got '0m'"),
        (["-s", "capstone"], "scenario must have two parties that compete, got capstone"),
        (["--secret-opponents", "nowhere"], "nowhere: cannot be read: No such file or directory"),
    ],
)
def test_wrong_options_are_one_line(folder, words, line):
    done = run("league", folder, *ARENA[2:], *words, columns=500)
    assert done.exit_code == 2
    assert line in done.output


def test_a_folder_without_an_entry_is_refused(tmp_path):
    done = league(tmp_path)
    assert done.exit_code == 2
    assert "has no entry; it needs a .py file or a sub-folder for each person" in done.output


def test_other_settings_than_before_are_refused_and_nothing_is_lost(ran):
    before = matches(ran)
    done = league(ran, "--set", "time_limit_s=4")
    assert done.exit_code == 2
    assert "is of another tournament: time_limit_s is 3" in done.output
    assert matches(ran) == before


def test_a_site_that_a_user_edited_is_written_again_and_other_files_stay(ran):
    table = (ran / "site" / "index.html").read_text()
    (ran / "site" / "index.html").write_text("edited")
    (ran / "site" / "notes.txt").write_text("mine")
    league(ran)
    assert (ran / "site" / "index.html").read_text() == table
    assert (ran / "site" / "notes.txt").read_text() == "mine"


def test_a_file_in_the_place_of_the_site_costs_no_match(folder):
    (folder / "site").write_text("a file")
    done = league(folder)
    assert done.exit_code == 2
    assert "site: cannot be written: is not a folder" in done.output
    played = matches(folder)
    (folder / "site").unlink()
    assert "0 new matches" in league(folder).output
    assert matches(folder) == played


def test_only_the_replays_that_pages_need_stay(ran):
    kept = len(list((ran / ".league" / "replays").glob("*.replay")))
    agents = 2 + len(shipped_entries(2))
    assert kept < len(matches(ran))
    assert kept <= 5 * agents
    page = page_of(ran, "ann")
    assert page.count("<catch-replay id=") == 2


def test_a_league_that_runs_again_and_again_outlives_an_error(folder, monkeypatch):
    """The second and the third run fail; the fourth one goes on."""
    runs, pauses = [], []
    errors = {2: StoreError("the disk is full"), 3: PermissionError(errno.EACCES, "Permission denied", "robots/ann")}

    def run_once(*_, **__):
        runs.append(1)
        if len(runs) in errors:
            raise errors[len(runs)]
        return SimpleNamespace(new_matches=0)

    def sleep(seconds):
        pauses.append(seconds)
        if len(pauses) == 4:
            raise KeyboardInterrupt

    monkeypatch.setattr(update, "update_league", run_once)
    monkeypatch.setattr(site, "write_site", lambda _: folder)
    monkeypatch.setattr(league_command.time, "sleep", sleep)
    done = league(folder, "--every", "15m")
    assert done.exit_code == 0
    assert "error: the disk is full\nerror: robots/ann: Permission denied\n" in done.stderr
    assert (len(runs), pauses) == (4, [900.0] * 4)


def test_a_clock_that_is_set_back_keeps_the_order_of_runs(ran):
    with Store.read(ran / ".league") as found:
        tournament = found.tournament
    with LeagueStore.begin(tournament, ran / ".league", resume=True) as store:
        last = datetime.fromisoformat(store.ratings()[-1].time)
        assert store.time_after(last - timedelta(days=1)) == (last + timedelta(seconds=1)).isoformat()
        later = last + timedelta(hours=1)
        assert store.time_after(later) == later.isoformat()


def test_old_ratings_are_thinned_out_to_one_run_a_day(ran):
    with Store.read(ran / ".league") as found:
        tournament = found.tournament
    with LeagueStore.begin(tournament, ran / ".league", resume=True) as store:
        begin = datetime(2030, 1, 1, tzinfo=timezone.utc)
        times = [(begin + timedelta(hours=6 * number)).isoformat() for number in range(200)]
        for time_ in times:
            store.add_ratings([RatingThen(0, time_, None, 0.0, None, None)])
        kept = [one.time for one in store.ratings() if one.time >= begin.isoformat()]
    assert kept == [*times[3:100:4], *times[100:]]


def test_old_matches_are_removed_in_whole_blocks(ran):
    before = matches(ran)
    with Store.read(ran / ".league") as found:
        tournament = found.tournament
    with LeagueStore.begin(tournament, ran / ".league", resume=True) as store:
        store.remove_old(5)
        assert [one.match.id for one in store.played()] == sorted(before)[-4:]  # a block has two matches
        rounds, block = store.next_block()
    assert (rounds, block) == (1, len(before) // 2)


def test_opponents_are_near_and_new_to_each_other():
    def draw(_, other):
        return other

    ratings = {index: Estimate(100.0 * index, 0.0, 0.0) for index in range(100)}
    met = {(49, 50): 10, (50, 51): 10}
    (block,) = next_blocks([50], range(100), Evidence(ratings, {}, met), 3, draw)
    assert block == (50, 48, 52)
    (first,) = next_blocks([100], range(101), Evidence(ratings), 3, draw)
    assert set(first) <= {100, 48, 49, 50, 51}  # without a rating it begins in the middle
    both = next_blocks([10, 11, 90], range(100), Evidence(ratings), 2, draw)
    assert both == [(10, 11), (90, 89)]  # those that wait meet each other


def test_with_prey_the_ratings_are_those_of_hunters():
    config = scenario("tag", time_limit_s=3)
    entrants, parties = enter(["nearest", "intercept", "patrol", "contested", "idle"]), Parties.of(config)
    played = play(config, entrants, round_robin(5, parties, 1, 3))
    evidence = weigh(played, parties, 0, range(5))
    assert set(evidence.met) == set(combinations(range(5), 2))
    table = standings(SideResults.of(entrants, played, parties, "hunter"))
    ratings = {line.name: line.rating.mean for line in table}
    for index, entrant in enumerate(entrants):
        assert evidence.ratings[index].mean == pytest.approx(ratings[entrant.name] - ratings["nearest"], abs=0.1)


def test_a_match_that_did_not_begin_is_the_worst_only_if_there_is_no_other():
    config = scenario("duel", time_limit_s=3)
    entrants, parties = enter(["nearest", "idle"]), Parties.of(config)
    played = play(config, entrants, round_robin(2, parties, 2, 3))
    failures = ("FORFEIT_INIT", 0), ("FORFEIT_CRASH", 7)
    parts = [Part(one, one.match.seating.index(0)) for one in played]
    for part, failure in enumerate(failures):
        one, party = parts[part]
        forfeits = tuple(Forfeit(*failure, "") if party == at else None for at in range(2))
        parts[part] = Part(replace(one, result=replace(one.result, forfeits=forfeits)), party)
    best, worst = best_and_worst(parts, parties)
    assert best.forfeit is None
    assert worst is parts[1]
    assert best_and_worst(parts[:1], parties) == (parts[0], parts[0])
