"""Full disks, folders that are gone and links that lead to themselves: no command ends in a traceback."""

import csv
import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from catch_arena import Replay

QUICK = ["-s", "duel", "--set", "time_limit_s=3", "--trusted"]
MODULE = """
print("one")
class Agent:
    def reset(self, seed):
        print("two", flush=True)
    def act(self, view):
        return 1 if view.targets else 0
def arbiter(**given):
    return {}
"""


def run(folder, *words, **options):
    """The command, in a process of its own: `catch-arena WORDS`."""
    return subprocess.run(
        [sys.executable, "-m", "catch_arena", *words],
        cwd=folder,
        env={**os.environ, "PYTHONIOENCODING": "utf-8"},
        stderr=subprocess.PIPE,
        encoding="utf-8",
        check=False,
        **({"stdout": subprocess.PIPE} | options),
    )


@pytest.mark.parametrize(
    "change", ["os.chdir('/')", "sys.stdout = sys.stderr = open(os.devnull, 'w')", "sys.path.clear()"]
)
def test_the_import_of_a_trusted_agent_moves_and_silences_nothing(tmp_path, change):
    (tmp_path / "dé.py").write_text(f"import os, sys\n{change}\n{MODULE}", encoding="utf-8")
    done = run(tmp_path, "match", "dé.py", "idle", *QUICK, "-o", "m.replay", "--seed", "1")
    assert (done.returncode, done.stderr) == (0, "")
    assert "dé (hunter_0)" in done.stdout
    assert done.stdout.endswith("seed: 1\nreplay: m.replay\n")
    assert Replay.load(tmp_path / "m.replay").names == ("dé", "idle")


def test_without_semaphores_several_processes_are_refused_and_one_plays(catch_arena, monkeypatch):
    """A sandbox or a container may have a /dev/shm that cannot be written."""

    def refuse(*_):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr("multiprocessing.synchronize._multiprocessing.SemLock", refuse)
    Path("mine.py").write_text(MODULE)
    words = ["tournament", "mine.py", "idle", *QUICK, "--rounds", "1", "--out", "t", "--resume"]
    many = catch_arena(*words, "-j", "2")
    assert many.exit_code == 2
    assert "error: processes need a writable /dev/shm: Read-only file system; -j 1 needs none" in many.stderr
    one = catch_arena(*words, "-j", "1")
    assert one.exit_code == 0, one.output


SPEC = """
seed = 1
matches = 1
[[test]]
name = "t"
scenario = "duel"
opponents = ["nearest"]
settings = { time_limit_s = 3 }
min_mean_score = 100.0
"""


@pytest.mark.parametrize(
    ("words", "status", "written"),
    [
        (["match", "nearest", "idle", *QUICK, "-o", "m.replay"], 0, "m.replay"),
        (["grade", "idle", "--spec", "spec.toml", "--json", "g.json"], 1, "g.json"),
        (["scenarios"], 0, None),
        (["match", "--help"], 0, None),
        ([], 2, None),
        (["check-agent", "mine.py", "--scenario", "duel", "--trusted"], 0, None),
        (["conformance", "mine.py:arbiter", "--only", "reach.299999"], 1, None),
        (["tournament", "mine.py", "idle", *QUICK, "--rounds", "1", "--jobs", "2"], 0, "out/tournament/standings.csv"),
    ],
    ids=lambda words: " ".join(words[:2]) if isinstance(words, list) else "",
)
def test_a_command_whose_reader_has_gone_works_to_its_end(tmp_path, words, status, written):
    """For example `catch-arena grade ... | head -1`; an agent that prints to the closed pipe does not forfeit."""
    (tmp_path / "spec.toml").write_text(SPEC)
    (tmp_path / "mine.py").write_text(MODULE)
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as gone:
        done = run(tmp_path, *words, stdout=gone)
    assert done.returncode == status
    assert "error" not in done.stderr
    if written is not None:
        assert (tmp_path / written).stat().st_size
    if words[:1] == ["tournament"]:
        with (tmp_path / written).open(newline="") as standings:
            assert [row["forfeits"] for row in csv.DictReader(standings)] == ["0", "0"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
@pytest.mark.parametrize(
    "words",
    [["--version"], ["match", "--help"], ["scenarios"], ["match", "idle", "idle"]],
)
def test_a_full_disk_behind_stdout_is_one_line(tmp_path, words):
    with Path("/dev/full").open("w") as full:
        done = run(tmp_path, *words, *(QUICK if words[-1] == "idle" else ()), stdout=full)
    assert done.returncode == 2
    assert done.stderr == "error: the output cannot be written: No space left on device\n"


def test_a_working_folder_that_was_deleted_is_one_line(tmp_path):
    (tmp_path / "gone").mkdir()
    words = ["match", "nearest", "idle", *QUICK]
    script = "import os, sys, runpy; os.rmdir(os.getcwd()); runpy.run_module('catch_arena', run_name='__main__')"
    done = subprocess.run(
        [sys.executable, "-c", script, *words], cwd=tmp_path / "gone", capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "error: the working folder was deleted; change to another folder\n"


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["match", "loop.py", "idle"], "loop.py: is a link that leads to no file"),
        (["report", "loop"], "loop: holds no tournament"),
        (["mosaic", "loop", "-o", "x.mp4"], "loop: is not a folder"),
        (["match", "idle", "idle", "-o", 300 * "x" + ".replay"], "x.replay: cannot be written: File name too long"),
    ],
)
def test_a_name_that_leads_nowhere_is_one_line(tmp_path, words, why):
    for name in ("loop", "loop.py"):
        (tmp_path / name).symlink_to(name)
    done = run(tmp_path, *words, *(QUICK if words[0] == "match" else ()))
    assert (done.returncode, done.stdout) == (2, "")
    assert why in done.stderr
    assert len(done.stderr.splitlines()) == 1
