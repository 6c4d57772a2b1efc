"""The benchmark runs from end to end; what it measures is not tested."""

import ctypes
import importlib.util
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import catch_arena

ROOT = Path(__file__).parent.parent.parent
COMPILED = {name: value for name, value in os.environ.items() if name != "NUMBA_DISABLE_JIT"}


def bench(*arguments, folder=ROOT, environment=COMPILED):
    command = [sys.executable, "scripts/bench", *map(str, arguments)]
    return subprocess.run(command, cwd=folder, env=environment, check=False, capture_output=True, text=True)


def module(name, monkeypatch):
    """One of the benchmark's own."""
    monkeypatch.syspath_prepend(ROOT / "scripts" / "bench")
    spec = importlib.util.spec_from_file_location(f"bench_{name}", ROOT / "scripts" / "bench" / f"{name}.py")
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """One quick run, without the rows that start processes: the folder that it wrote into."""
    folder = tmp_path_factory.mktemp("bench")
    (folder / "page.md").write_bytes((ROOT / "docs" / "explanation" / "performance.md").read_bytes())
    rows = ("peers", "batch", "threads", "hunters", "targets", "one-arena", "learners", "resets", "memory")
    done = bench("--quick", "--only", *rows, "--json", folder / "bench.json", "--page", folder / "page.md")
    assert done.returncode == 0, done.stderr
    return folder


def test_every_peer_is_measured_or_named_as_skipped(run):
    """In the page and in the JSON, whatever is installed here."""
    figures = json.loads((run / "bench.json").read_text())
    page = (run / "page.md").read_text()
    measured = figures["versions"]["peers"]

    assert len(measured | figures["skipped"]) == 8
    assert measured.keys().isdisjoint(figures["skipped"])
    assert "--pufferlib" in figures["skipped"]["PufferLib target, 14 goals, 1,024 at once"]
    for name in measured:
        assert page.count(f"\n| {name} ") == 2, "its cost, and how many times as fast ours are"
    for name, reason in figures["skipped"].items():
        assert f"Skipped: {name} ({reason})." in page


def test_the_table_has_every_row_with_its_sizes_and_its_rate(run):
    page = (run / "page.md").read_text()
    (cells,) = re.findall(
        r"^\| what .*\n\|[-:| ]+\n((?:\|.*\n)+)", page.partition("made by make bench")[2], re.MULTILINE
    )
    rows = {
        row[0]: row[1:] for row in ([cell.strip() for cell in line[2:-2].split(" | ")] for line in cells.splitlines())
    }
    for hunters, floats in ((4, 71), (16, 99), (64, 99)):
        assert rows[f"{hunters} hunters"][:2] == [str(hunters), str(floats)]
    for name in ("batch of 1,024", "batch of 16,384, two threads", "one arena, full control", "LearnerBatch, patrol"):
        assert rows[name][0] == "4"
        assert float(rows[name][5].replace(",", "")) > 0
    assert rows["reset of one arena"][3] == "us per reset"
    assert rows["memory"][3] == "bytes per arena"
    assert {len(row) for row in rows.values()} == {6}


def test_the_page_keeps_what_is_written_by_hand(run):
    """Only what stands between the marks changes."""
    old = (ROOT / "docs" / "explanation" / "performance.md").read_text()

    assert (run / "page.md").read_text().startswith(old.partition("<!-- made by make bench -->")[0])


@pytest.mark.nightly
def test_processes_from_their_beginning_to_their_end_are_measured(tmp_path):
    """A first step, a video and a tournament."""
    done = bench("--quick", "--only", "warm", "cold", "render", "isolation", "--json", tmp_path / "bench.json")
    assert done.returncode == 0, done.stderr
    figures = json.loads((tmp_path / "bench.json").read_text())
    measured = figures["versions"]["now"]
    assert figures["skipped"].keys() <= {"tournament, namespaces"}
    assert min(measured["first step, cold"]["cpu"]) > max(measured["first step, warm"]["cpu"])
    assert all(min(row["cpu"]) > 0 for row in measured.values())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--only", "everything"), "invalid choice: 'everything'"),
        (("--against", "HEAD", "--only", "peers"), "--against measures no peers"),
        (("--pufferlib", "docs"), "docs has no pufferlib/ocean/target/target.h"),
        (
            ("--against", "HEAD", "--page", "docs/explanation/performance.md"),
            "--against measures no peers and writes no page",
        ),
        (("--rounds", 0), "--rounds must be at least 1"),
        (("--json", "README.md/figures.json"), "README.md: cannot be written: is a file, not a folder"),
        (("--page", "README.md"), "--page must be a page that has the marks"),
        (("--page", "no.md"), "got no.md"),
    ],
)
def test_bad_arguments_are_one_line(arguments, message):
    """Before anything is measured."""
    done = bench("--quick", *arguments)

    assert done.returncode == 2
    assert message in done.stderr.splitlines()[-1]


def test_a_large_batch_is_at_all_ages_of_an_episode(monkeypatch):
    """Neighbours, of which a block of memory is made, at the same one; all arenas differ."""
    config = catch_arena.scenario("standard", time_limit_s=9.6)
    arena = catch_arena.VectorArena(config, 1024)
    arena.reset(2)
    module("ours", monkeypatch).spread(arena, [np.ones((1024, 4), dtype=np.int64)])

    ages = np.array([arena.world(row).step for row in range(1024)]).reshape(32, 32)
    assert (ages == ages[:, :1]).all()
    assert ages[:, 0].tolist() == [config.max_steps * age // 32 for age in range(32)]
    assert len({arena.save_row(row).memory.tobytes() for row in range(1024)}) == 1024


# ---- beside an older commit ----


class Repository:
    """A small one of its own: an older commit, which lacks an API, the current one, and a change on top."""

    def __init__(self, folder):
        self.folder = folder / "repository"
        self.temporary = folder / "temporary"
        self.temporary.mkdir()
        for part in ("catch_arena", "scripts/bench"):
            shutil.copytree(ROOT / part, self.folder / part, ignore=shutil.ignore_patterns("__pycache__"))
        self.git("init", "--quiet")
        names = self.folder / "catch_arena" / "__init__.py"
        current = names.read_text()
        older = "".join(line for line in current.splitlines(keepends=True) if '"parallel_env":' not in line)
        for text in (older, current):
            names.write_text(text)
            self.git("add", "--all")
            self.git("-c", "user.name=one", "-c", "user.email=one@example.org", "commit", "--quiet", "-m", "a commit")
        names.write_text(current + "# changed\n")

    def git(self, *arguments):
        command = ["git", "-C", self.folder, *arguments]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout

    @property
    def environment(self):
        """Without the compiler, which would take a minute; not covered, as the sources will be gone."""
        kept = {name: value for name, value in os.environ.items() if not name.startswith(("COV_", "COVERAGE_"))}
        return {
            **kept,
            "NUMBA_DISABLE_JIT": "1",
            "PYTHONDONTWRITEBYTECODE": "1",
            "TMPDIR": str(self.temporary),
        }

    def bench(self, *arguments):
        return bench("--quick", "--against", *arguments, folder=self.folder, environment=self.environment)

    def left(self):
        """What a run has left behind."""
        return [*self.temporary.iterdir(), *self.git("worktree", "list").splitlines()[1:]]


@pytest.fixture(scope="module")
def repository(tmp_path_factory):
    return Repository(tmp_path_factory.mktemp("against"))


@pytest.mark.nightly
def test_an_older_commit_and_the_current_version_are_measured_in_turn(repository, tmp_path):
    """Rows that need no compiler; with uncommitted changes, which the output names."""
    rows = ("batch", "threads", "hunters", "controls", "one-arena", "learners", "memory")
    done = repository.bench("HEAD", "--only", *rows, "--json", tmp_path / "bench.json")
    assert done.returncode == 0, done.stderr

    figures = json.loads((tmp_path / "bench.json").read_text())
    before, now = figures["versions"]["before"], figures["versions"]["now"]
    assert repository.git("rev-parse", "HEAD").strip()[:12] in figures["what"]
    assert before.keys() == now.keys()
    assert {len(row["cpu"]) for row in (*before.values(), *now.values())} == {2}
    assert "with changes that are not committed" in done.stdout
    for what in (
        "batch of 1,024, ns per agent-step",
        "one arena, full control, us per step",
        "memory, bytes per arena",
    ):
        assert f"| {what}" in done.stdout
    assert repository.left() == []


@pytest.mark.parametrize(
    ("ref", "message"),
    [
        (
            "HEAD~1",
            "bench: HEAD~1 ({}) cannot be measured: AttributeError: module 'catch_arena' has no .*'parallel_env'",
        ),
        ("no-such-ref", "bench: --against must name a commit of this repository, got 'no-such-ref'"),
        ("HEAD:scripts", "bench: --against must name a commit of this repository, got 'HEAD:scripts'"),
        ("--all", "bench: error: argument --against: expected one argument"),
    ],
)
def test_what_cannot_be_measured_is_one_line(repository, ref, message):
    """An older commit that lacks an API, which also shows that it is the older one that is imported; and no commit."""
    done = repository.bench(ref, "--only", "one-arena")

    older = repository.git("rev-parse", "HEAD~1")[:12]
    assert done.returncode != 0
    assert re.fullmatch(message.replace("({})", rf"\({older}\)"), done.stderr.splitlines()[-1])
    assert "Traceback" not in done.stderr
    assert repository.left() == []


def test_without_git_or_history_it_says_so(repository, tmp_path):
    """In one line each."""
    shutil.copytree(repository.folder / "scripts", tmp_path / "unpacked" / "scripts")
    environment = {**repository.environment, "GIT_CEILING_DIRECTORIES": str(tmp_path)}
    unpacked = bench("--against", "HEAD", "--quick", folder=tmp_path / "unpacked", environment=environment)
    without = bench("--against", "HEAD", "--quick", folder=repository.folder, environment={**environment, "PATH": ""})

    assert re.fullmatch(r"bench: --against needs .*, and \S*unpacked is not a git checkout\n", unpacked.stderr)
    assert without.stderr == "bench: --against needs git, which is not installed here\n"
    assert unpacked.returncode == without.returncode == 1


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_leaves_no_checkout_and_no_process_behind(repository, number):
    """While it measures."""
    command = [sys.executable, "scripts/bench", "--against", "HEAD", "--quick", "--only", "hunters"]
    with subprocess.Popen(
        command, cwd=repository.folder, env=repository.environment, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr.readline() == "compiling\n"
        sides = children_of(process.pid)
        process.send_signal(number)
        _, words = process.communicate(timeout=240)

    assert process.returncode == 130
    assert words.splitlines()[-1] == "bench: interrupted"
    assert repository.left() == []
    assert len(sides) >= 2
    late = time.monotonic() + 10
    while any(Path("/proc", side).exists() for side in sides):  # Python's own helper ends a moment later
        assert time.monotonic() < late
        time.sleep(0.05)


def children_of(pid):
    return Path(f"/proc/{pid}/task/{pid}/children").read_text().split()


# ---- PufferLib's target ----

HEADER = """
#include <stdlib.h>
typedef struct {
    int width, height, num_agents, num_goals;
    float *observations, *rewards;
    int* actions;
    unsigned char* terminals;
} Target;
__attribute__((visibility("default"))) int begun, played, least_turn = 9, most_turn, least_push = 9, most_push;
static void fill(Target* env) {
    for (int seat = 0; seat < env->num_agents; seat++) {
        int turn = env->actions[2 * seat], push = env->actions[2 * seat + 1];
        int floats = 2 * (env->num_agents + env->num_goals) + 4;
        least_turn = turn < least_turn ? turn : least_turn, most_turn = turn > most_turn ? turn : most_turn;
        least_push = push < least_push ? push : least_push, most_push = push > most_push ? push : most_push;
        for (int column = 0; column < floats; column++) env->observations[seat * floats + column] = 1;
        env->rewards[seat] = env->terminals[seat] = 1;
    }
}
void init(Target* env) { begun += env->num_goals == 14 && env->width == 1080 && env->height == 720; }
void c_reset(Target* env) { fill(env); }
void c_step(Target* env) { fill(env), played++; }
"""
"""Of the same form as theirs."""


@pytest.mark.nightly
def test_pufferlib_is_compiled_and_driven_where_its_source_lies(tmp_path, monkeypatch):
    """With a header of our own in its place that looks at what it is given, and with one that does not compile."""
    peers = module("peers", monkeypatch)
    header = tmp_path / peers.HEADER
    header.parent.mkdir(parents=True)
    header.write_text(HEADER)
    subject = peers.pufferlib_target(tmp_path, envs=100, goals=14, steps=5)
    subject.step()
    subject.step()
    library = subject.step.__closure__[0].cell_contents
    names = ("begun", "played", "least_turn", "most_turn", "least_push", "most_push")
    assert [ctypes.c_int.in_dll(library, name).value for name in names] == [100, 1000, 0, 8, 0, 4]

    header.write_text("no C at all")
    with pytest.raises(RuntimeError, match=r"^pufferlib/ocean/target/target\.h:1:1: error"):
        peers.compiled(tmp_path)


def test_the_memory_of_a_batch_is_counted(monkeypatch):
    measured = module("ours", monkeypatch).memory(2048).value()
    batch = catch_arena.VectorArena("standard", 2048)
    assert batch.reset(seed=1)[0].nbytes / 2048 < measured < 50_000
