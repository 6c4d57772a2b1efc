"""Matches on Ray have the same results as local ones, and every machine must have the same versions."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import run
from tournament.agents import dies_once
from tournament.runs import exported

from catch_arena import scenario
from catch_arena.errors import AgentError, ConfigError
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution.executors import Worker
from catch_arena.tournament.execution.ray_executor import require_same
from catch_arena.tournament.players import enter
from catch_arena.tournament.store import versions

WORDS = ["nearest", "crashes.py", "--scenario", "duel", "--set", "time_limit_s=3", "--rounds", "4", "--record"]
WORDS += ["--seed", "0", "--trusted", "--max-forfeits", "3"]


def played(folder, name: str, *words: str):
    """The exit code and the errors of a tournament in a process of its own, as Ray starts threads that stay."""
    command = [sys.executable, "-m", "catch_arena", "tournament", "dies_once.py", *WORDS]
    words = (*command, "--out", name, *words)
    return subprocess.run(words, check=False, cwd=folder, capture_output=True, text=True, timeout=300)


@pytest.mark.extras
def test_two_workers_of_which_one_is_killed_play_as_this_process_does(tmp_path, monkeypatch):
    dies_once(tmp_path)
    shutil.copy(Path(__file__).parents[1] / "isolation" / "bad" / "crashes.py", tmp_path)
    on_ray = played(tmp_path, "ray", "--executor", "ray", "--jobs", "2")
    assert on_ray.returncode == 0, on_ray.stderr
    assert (tmp_path / "died").exists()
    monkeypatch.chdir(tmp_path)
    here = run("tournament", "dies_once.py", *WORDS, "--out", "here", "--jobs", "1")
    assert here.exit_code == 0, here.output
    assert exported(tmp_path / "ray") == exported(tmp_path / "here")
    assert exported(tmp_path / "here").count(b"FORFEIT_OUT") == 12
    replays = [
        {path.name: path.read_bytes() for path in (tmp_path / name / "replays").iterdir()} for name in ("ray", "here")
    ]
    assert replays[0] == replays[1]
    assert len(replays[0]) == 24


def test_a_machine_with_other_versions_or_another_agent_does_not_play(tmp_path):
    (tmp_path / "mine.py").write_text(
        "class Agent:\n    def reset(self, seed): pass\n    def act(self, view): return 0\n"
    )
    worker = Worker(scenario("duel"), enter([str(tmp_path / "mine.py")]))
    require_same(worker, tuple(versions().items()))
    with pytest.raises(ConfigError, match=r"numpy must be 1\.0 on every machine, got \d"):
        require_same(worker, (("numpy", "1.0"),))
    with (tmp_path / "mine.py").open("a") as file:
        file.write("# another\n")
    with pytest.raises(AgentError, match=r"mine: digest must be \w{16} on every machine, got \w{16} on "):
        require_same(worker, ())
    (tmp_path / "lacks.py").write_text("import no_such_module\n")
    lacks = Entrant("lacks", str(tmp_path / "lacks.py"), "target", "")
    with pytest.raises(AgentError, match=r"lacks: cannot begin on .*: it imports no_such_module"):
        require_same(Worker(scenario("duel"), (lacks,)), ())
