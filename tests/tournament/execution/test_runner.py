"""Playing a plan: the number of processes changes nothing, and failures leave nothing behind."""

import json
import os
from typing import ClassVar

import pytest
from tournament.agents import dies_once
from tournament.execution.test_process_executor import helpers

from catch_arena import Replay, scenario
from catch_arena.descendants import family
from catch_arena.errors import ConfigError, NoContest, OutputError
from catch_arena.files import prepare_folder
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.execution.runner import LOGS, REPLAYS, run
from catch_arena.tournament.match import blocks_of
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.secret import Secret
from catch_arena.tournament.standings_files import write_standings
from catch_arena.tournament.statistics.standings import standings
from catch_arena.tournament.store import Tournament

SHORT = scenario("duel", time_limit_s=6)
"""Seats a strong and an idle agent at each table of the first round."""


def test_one_process_or_two_give_the_same_results_and_replays(tmp_path):
    entrants = enter(["nearest", "random", "patrol", "random"])
    plan = round_robin(len(entrants), 2, 1, seed=5)
    played = []
    for jobs in (1, 2):
        folder = prepare_folder(tmp_path / str(jobs))
        played.append(run(SHORT, entrants, plan, jobs=jobs, record=folder))
    one, two = ({path.name: path.read_bytes() for path in (tmp_path / jobs / REPLAYS).iterdir()} for jobs in "12")
    assert played[0] == played[1]
    assert [one.match for one in played[0]] == list(plan)
    assert one == two
    assert len(one) == len(plan)
    for match in plan:
        replay = Replay.load(tmp_path / "1" / REPLAYS / f"{match.id}.replay")
        assert replay.names == tuple(entrants[place].name for place in match.seating)


def test_a_second_plan_with_the_same_seed_repeats_the_first():
    entrants = enter(["nearest", "random"])
    plan = round_robin(2, 2, 2, seed=1)
    assert run(SHORT, entrants, plan) == run(SHORT, entrants, list(plan))


def test_the_random_agent_plays_alike_in_a_block_and_the_targets_are_the_same(tmp_path):
    """A block's matches have one seed: R3.3 puts the targets in the same places whatever the seating."""
    entrants = enter(["nearest", "random"])
    plan = round_robin(2, 2, 1, seed=2)
    run(SHORT, entrants, plan, record=tmp_path)
    starts = [next(Replay.load(tmp_path / REPLAYS / f"{match.id}.replay").worlds()).targets for match in plan]
    assert starts[0] == starts[1]


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_failing_agent_spoils_its_own_matches_only_and_no_process_stays(tmp_path, jobs):
    bad = tmp_path / "bad.py"
    bad.write_text("class Agent:\n    def reset(self, seed): pass\n    def act(self, view): return -1\n")
    entrants = enter([str(bad), "nearest", "idle"])
    before = family(os.getpid())
    played = run(SHORT, entrants, round_robin(3, 2, 2, seed=0), jobs=jobs, record=tmp_path)
    assert len(played) == 12
    for one in played:
        codes = ["FORFEIT_ILLEGAL" if place == 0 else None for place in one.match.seating]
        assert list(one.result.forfeits) == codes
    assert [path.name for path in (tmp_path / LOGS).iterdir()] == ["bad.log"]
    assert (tmp_path / LOGS / "bad.log").read_text().count("FORFEIT_ILLEGAL in step 1: an action must be") == 8
    assert family(os.getpid()) - before <= helpers()


def test_a_worker_that_dies_every_time_is_told_with_its_match(tmp_path):
    bad = tmp_path / "bad.py"
    bad.write_text("import os\nclass Agent:\n    def reset(self, seed): pass\n    def act(self, view): os._exit(1)\n")
    before = family(os.getpid())
    with pytest.raises(NoContest, match=r"match r00001-g000001.* failed 3 times: a worker process died"):
        run(SHORT, enter([str(bad), "nearest"]), round_robin(2, 2, 1, seed=0), jobs=2)
    assert family(os.getpid()) - before <= helpers()


def test_a_match_whose_worker_was_killed_is_played_again(tmp_path):
    """The first match kills its process as the kernel would; the results are those of an undisturbed run."""
    names = [dies_once(tmp_path), "nearest", "random"]
    plan = round_robin(3, 2, 2, seed=0)
    disturbed = run(SHORT, enter(names), plan, jobs=2)
    assert (tmp_path / "died").exists()
    assert disturbed == run(SHORT, enter(names), plan)


class Growing:
    """Plays a block more for as long as the first entrant has won all."""

    parameters: ClassVar = {"format": "growing"}
    size = 20

    def __init__(self):
        self.asked = []

    def stage(self, number, played):
        matches = list(played)
        self.asked.append(len(matches))
        won = all(one.result.ranks[one.match.seating.index(0)] == 1 for one in matches)
        return blocks_of(match for match in round_robin(2, 2, number + 1, 0) if match.block == number) if won else ()


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_plan_may_grow_by_what_was_played(jobs):
    plan = Growing()
    played = run(SHORT, enter(["nearest", "random"]), plan, jobs=jobs)
    assert plan.asked == list(range(0, len(played) + 1, 2))
    lost = [one.match.block for one in played if one.result.ranks[one.match.seating.index(0)] != 1]
    assert set(lost) == {played[-1].match.block}
    assert len(played) > 2


def test_no_process_is_no_way_to_play():
    with pytest.raises(ConfigError, match="jobs must be at least 1, got 0"):
        run(SHORT, enter(["idle", "idle"]), round_robin(2, 2, 1, seed=0), jobs=0)


def test_a_folder_that_cannot_be_is_refused_before_play(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="file: cannot be written: is a file, not a folder"):
        prepare_folder(tmp_path / "file" / "results")


def test_standings_replace_older_ones_and_leave_other_files_alone(tmp_path):
    entrants = enter(["nearest", "idle"])
    (tmp_path / "notes.txt").write_text("mine")
    for seed in (1, 2):
        plan = round_robin(2, 2, 1, seed=seed)
        played = run(SHORT, entrants, plan)
        facts = Tournament(SHORT, entrants, plan.parameters, secret=Secret.of(seed))
        write_standings(tmp_path, facts, 2, {"hunter": standings(entrants, played)})
    assert sorted(path.name for path in tmp_path.iterdir()) == ["notes.txt", "standings.csv", "standings.json"]
    assert json.loads((tmp_path / "standings.json").read_text())["seed"] == Secret.of(2).digits
