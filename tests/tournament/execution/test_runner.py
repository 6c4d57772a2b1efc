"""The number of processes changes no result, and a worker or agent that fails leaves no process behind."""

import os
from multiprocessing import resource_tracker

import pytest
from tournament.agents import dies_once, write_agent
from tournament.runs import run
from tournament.seats import hunters

from catch_arena import Replay, scenario
from catch_arena.files import prepare_folder
from catch_arena.interrupts import descendants
from catch_arena.tournament.execution.runner import LOGS, REPLAYS
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.players import enter

SHORT = scenario("duel", time_limit_s=6)
"""Seats a strong and an idle agent at each table of the first round."""


def helpers():
    """Return the processes that Python itself keeps until its end, once any process was started."""
    return {resource_tracker._resource_tracker._pid}


def test_one_process_or_two_give_the_same_results_and_replays(tmp_path):
    entrants = enter(["nearest", "random", "patrol", "random"])
    plan = round_robin(len(entrants), hunters(2), 1, seed=5)
    played = []
    for jobs in (1, 2):
        folder = prepare_folder(tmp_path / str(jobs))
        played.append(run(SHORT, entrants, plan, jobs=jobs, record=folder))
    one, two = ({path.name: path.read_bytes() for path in (tmp_path / jobs / REPLAYS).iterdir()} for jobs in "12")
    assert played[0] == played[1]
    assert [one.match for one in played[0]] == list(plan)
    assert one == two
    assert len(one) == plan.size
    for match in plan:
        replay = Replay.load(tmp_path / "1" / REPLAYS / f"{match.id}.replay")
        assert replay.names == tuple(entrants[place].name for place in match.seating)


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_failing_agent_spoils_its_own_matches_only_and_no_process_stays(tmp_path, jobs):
    entrants = enter([write_agent(tmp_path / "bad.py", "return -1"), "nearest", "idle"])
    before = descendants(os.getpid())
    played = run(SHORT, entrants, round_robin(3, hunters(2), 2, seed=0), jobs=jobs, record=tmp_path)
    assert len(played) == 12
    for one in played:
        codes = ["FORFEIT_ILLEGAL" if place == 0 else None for place in one.match.seating]
        assert list(one.result.forfeit_codes) == codes
    assert [path.name for path in (tmp_path / LOGS).iterdir()] == ["bad.log"]
    assert (tmp_path / LOGS / "bad.log").read_text().count("FORFEIT_ILLEGAL in step 1: an action must be") == 8
    assert descendants(os.getpid()) - before <= helpers()


def test_a_match_whose_worker_was_killed_is_played_again(tmp_path):
    """The first match kills its process as the kernel would; the results are those of an undisturbed run."""
    names = [dies_once(tmp_path), "nearest", "random"]
    plan = round_robin(3, hunters(2), 2, seed=0)
    before = descendants(os.getpid())
    disturbed = run(SHORT, enter(names), plan, jobs=2)
    assert (tmp_path / "died").exists()
    assert descendants(os.getpid()) - before <= helpers()
    assert disturbed == run(SHORT, enter(names), plan)


def test_a_trusted_agent_that_reads_finds_nothing(tmp_path):
    reads = write_agent(tmp_path / "reads.py", "return input()")
    one, _ = run(SHORT, enter([reads, "nearest"]), round_robin(2, hunters(2), 1, seed=0), jobs=2)
    assert [detail.reason for detail in one.result.forfeits if detail] == [
        "act raised EOFError: EOF when reading a line"
    ]
