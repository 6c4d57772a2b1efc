"""Playing a plan: the number of processes changes nothing, and failures leave nothing behind."""

import multiprocessing

import pytest

from catch_arena import Replay, scenario
from catch_arena.errors import AgentError, ConfigError, OutputError
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.results import prepare_folder, results_text, write_results
from catch_arena.tournament.runner import run
from catch_arena.tournament.schedule import round_robin
from catch_arena.tournament.standings import standings

SHORT = scenario("duel", time_limit_s=6)


def test_one_process_or_two_give_the_same_bytes(tmp_path):
    entrants = enter(["nearest", "random", "patrol", "random"])
    plan = round_robin(len(entrants), 2, 1, seed=5)
    for jobs in (1, 2):
        folder = prepare_folder(tmp_path / str(jobs))
        played = run(SHORT, entrants, plan, jobs=jobs, record=folder)
        table = standings(entrants, played)
        write_results(folder, config=SHORT, seed=5, entrants=entrants, played=played, table=table)
    one, two = ({path.name: path.read_bytes() for path in (tmp_path / jobs).iterdir()} for jobs in "12")
    assert one == two
    assert len(one) == 3 + len(plan)
    replay = Replay.load(tmp_path / "1" / f"{plan[3].id}.replay")
    assert replay.names == tuple(entrants[place].name for place in plan[3].seating)


def test_a_second_plan_with_the_same_seed_repeats_the_first():
    entrants = enter(["nearest", "random"])
    plan = round_robin(2, 2, 2, seed=1)
    assert results_text(entrants, run(SHORT, entrants, plan)) == results_text(entrants, run(SHORT, entrants, plan))


def test_the_random_agent_plays_alike_in_a_block_and_the_targets_are_the_same(tmp_path):
    """A block's matches have one seed: R3.3 puts the targets in the same places whatever the seating."""
    entrants = enter(["nearest", "random"])
    plan = round_robin(2, 2, 1, seed=2)
    run(SHORT, entrants, plan, record=tmp_path)
    starts = [next(Replay.load(tmp_path / f"{match.id}.replay").worlds()).targets for match in plan]
    assert starts[0] == starts[1]


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_failing_agent_is_named_with_its_match_and_no_process_stays(tmp_path, jobs):
    bad = tmp_path / "bad.py"
    bad.write_text("class Agent:\n    def reset(self, seed): pass\n    def act(self, view): return -1\n")
    entrants = enter([str(bad), "nearest", "idle"])
    with pytest.raises(AgentError, match=r"bad: .* got -1 \(step 1\), match r00001-g00000\d-s0\d"):
        run(SHORT, entrants, round_robin(3, 2, 2, seed=0), jobs=jobs)
    assert not multiprocessing.active_children()


def test_a_worker_that_dies_is_reported(tmp_path):
    bad = tmp_path / "bad.py"
    bad.write_text("import os\nclass Agent:\n    def reset(self, seed): pass\n    def act(self, view): os._exit(1)\n")
    with pytest.raises(AgentError, match="a worker process died"):
        run(SHORT, enter([str(bad), "nearest"]), round_robin(2, 2, 1, seed=0), jobs=2)


def test_no_process_is_no_way_to_play():
    with pytest.raises(ConfigError, match="jobs must be at least 1, got 0"):
        run(SHORT, enter(["idle", "idle"]), round_robin(2, 2, 1, seed=0), jobs=0)


def test_a_folder_that_cannot_be_is_refused_before_play(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot be written to: Not a directory"):
        prepare_folder(tmp_path / "file" / "results")


def test_results_replace_older_ones_and_leave_other_files_alone(tmp_path):
    entrants = enter(["nearest", "idle"])
    (tmp_path / "notes.txt").write_text("mine")
    for seed in (1, 2):
        played = run(SHORT, entrants, round_robin(2, 2, 1, seed=seed))
        write_results(
            tmp_path, config=SHORT, seed=seed, entrants=entrants, played=played, table=standings(entrants, played)
        )
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "notes.txt",
        "results.jsonl",
        "standings.csv",
        "standings.json",
    ]
    assert (tmp_path / "results.jsonl").read_text() == results_text(entrants, played)
