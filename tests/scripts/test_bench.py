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
from inspect import signature
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


def table(text, heading, words=""):
    """The rows of the first table after a heading, and after these words, without the line under the head."""
    found = re.search(rf"### {heading}\n.*?{words}.*?((?:^\|[^\n]*\n)+)", text, re.DOTALL | re.MULTILINE)
    head, _, *rows = found[1].splitlines()
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in (head, *rows)]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """One quick run: the folder that it wrote into. The phases, for which the step is compiled anew, have their own."""
    folder = tmp_path_factory.mktemp("bench")
    (folder / "page.md").write_bytes((ROOT / "docs" / "performance.md").read_bytes())
    done = bench(
        "--quick",
        "--only",
        "start",
        "peers",
        "ours",
        "limits",
        "--json",
        folder / "bench.json",
        "--page",
        folder / "page.md",
    )
    assert done.returncode == 0, done.stderr
    return folder


def test_every_peer_is_measured_or_named_as_skipped(run):
    """In the page and in the JSON, whatever is installed here."""
    figures = json.loads((run / "bench.json").read_text())
    page = (run / "page.md").read_text()
    measured = {one["name"] for one in figures["subjects"] if one["group"] == "peers"}

    assert len(measured | figures["skipped"].keys()) == 7
    assert measured.isdisjoint(figures["skipped"])
    assert "--pufferlib" in figures["skipped"]["PufferLib target"]
    for name in measured:
        assert name in [row[0].partition(",")[0] for row in table(page, "Beside others")]
        assert name in [row[0].partition(",")[0] for row in table(page, "Beside others", "How many times")]
    for name, reason in figures["skipped"].items():
        assert f"Skipped: {name} ({reason})." in page


def test_the_tables_are_complete(run):
    """Every control, batch, number of threads, of hunters and of targets; and every row as wide as its head."""
    page = (run / "page.md").read_text()
    interfaces = {tuple(row[:3]) for row in table(page, "One arena, and batches")[1:]}

    for interface in ("target control", "target control, masks read", "velocity control", "full control"):
        assert (f"Catch Arena, one arena, {interface}", "1", "1") in interfaces
    assert {("Catch Arena, batch, target control", "33", threads) for threads in "12"} <= interfaces
    assert [row[0].split()[0] for row in table(page, "More hunters")[1:]] == ["2", "4", "8", "16", "32", "64"]
    assert [row[0].split()[2] for row in table(page, "More targets")[1:]] == ["4", "8", "16", "32", "64"]
    for heading in ("Beside others", "One arena, and batches", "Reset and memory", "Import and start-up"):
        assert len({len(row) for row in table(page, heading)}) == 1


def test_the_parts_of_what_stands_in_the_way_add_up(run):
    """One arena's step by control, and a batch's memory."""
    page = (run / "page.md").read_text()
    _, *rows = table(page, "What stands in the way")
    assert [row[0] for row in rows] == ["target", "velocity", "full"]
    for _, whole, *parts in rows:
        assert float(whole) == pytest.approx(sum(map(float, parts)), abs=0.03)
        assert min(map(float, parts[:2])) > 0
    figures = json.loads((run / "bench.json").read_text())["limits"]
    *parts, whole = figures["memory_bytes"].values()
    assert sum(parts) == pytest.approx(whole)
    assert figures["two_threads"].keys() == {"numbers", "memory"}


def test_every_target_stands_beside_its_figure_or_says_that_there_is_none(run):
    """Those that a peer would be needed for are not left out."""
    rows = {row[0]: row[1:] for row in table((run / "page.md").read_text(), "Wanted, and measured")[1:]}

    memory, target = rows["memory of a batch of 33, bytes an arena"]
    assert float(memory.replace(",", "")) > 0
    assert target in {"wanted at most 4,000: met", "wanted at most 4,000: missed"}
    assert rows["batch of 1 beside PufferLib target, 14 goals, agent-steps"] == ["", "wanted 0.7: not measured"]
    assert len(rows) == 17
    for measured, target in rows.values():
        assert target.rpartition(": ")[2] in ({"met", "missed"} if measured else {"not measured"})


@pytest.mark.parametrize(
    ("bound", "at_most", "measured", "said"),
    [
        (1500, False, 653.2, "wanted 1,500: missed"),
        (1.8, False, 1.7951, "wanted 1.8: met"),
        (1.8, False, 1.7949, "wanted 1.8: missed"),
        (0.8, True, 0.80049, "wanted at most 0.8: met"),
        (0.8, True, 0.80051, "wanted at most 0.8: missed"),
        (4000, True, None, "wanted at most 4,000: not measured"),
    ],
)
def test_a_target_is_met_or_missed_by_the_digits_that_are_shown(bound, at_most, measured, said, monkeypatch):
    assert module("wanted", monkeypatch).Wanted(bound, at_most).said(measured) == said


PLAYED = """
import numpy, catch_arena
engine = catch_arena.Engine(catch_arena.scenario("standard"), 33)
engine.reset(range(33))
for _ in range(60):
    engine.step(numpy.ones((33, 4), int), numpy.zeros((33, 4, 2), numpy.float32))
print([engine.digest(arena).hex() for arena in range(33)], engine.rewards.tobytes().hex())
"""


def test_what_stands_in_for_a_phase_can_be_called_in_its_place(monkeypatch):
    """A phase that has another argument or name since is not noticed before somebody measures."""
    phases = module("phases", monkeypatch)
    for place, stand_ins in phases._PHASES.values():
        for name, stand_in in stand_ins.items():
            original, substitute = (signature(getattr(one, "py_func", one)) for one in (getattr(place, name), stand_in))
            substitute.bind(*original.parameters)


def test_all_who_call_a_phase_are_compiled_anew_without_it(monkeypatch):
    """Who is not goes on calling it, and the phase seems to take no time."""
    phases = module("phases", monkeypatch)
    made_anew = {name for _, name in phases._CALLED} | {phases._CALLER}

    def callers(place, name):
        functions = [getattr(one, "py_func", None) for one in vars(place).values()]
        found = [one for one in functions if one is not None and one.__globals__ is vars(place)]
        return {one.__name__ for one in found if name in one.__code__.co_names}

    places = [place for place, _ in phases._PHASES.values()]
    waiting = [(place, name) for place, stand_ins in phases._PHASES.values() for name in stand_ins]
    while waiting:
        found = callers(*waiting.pop())
        assert found
        assert found <= made_anew
        waiting += [(place, name) for name in found - {phases._CALLER} for place in places if callers(place, name)]
    assert [name for _, name in phases._CALLED] == ["rank_seen", "observe", "play"], "what is called stands first"


@pytest.mark.nightly
def test_the_phases_of_a_step_add_up_to_the_whole(tmp_path):
    """As far as rounding goes; the rest has a row of its own, and what only moves memory stands below."""
    empty = {**COMPILED, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    done = bench("--quick", "--only", "phases", "--json", tmp_path / "bench.json", environment=empty)
    assert done.returncode == 0, done.stderr
    rows = [row[0] for row in table(done.stdout, "Where a step's time goes")]
    for batch in json.loads((tmp_path / "bench.json").read_text())["phases"]:
        *phases, whole, _, _ = batch["ns_per_agent_step"]
        assert whole == "the whole step"
        assert {*phases, whole} <= {*rows}
        spent = batch["ns_per_agent_step"]
        assert sum(spent[name] for name in phases) == pytest.approx(spent[whole])
    played = [
        subprocess.run([sys.executable, "-c", PLAYED], env=environment, check=True, capture_output=True).stdout
        for environment in (empty, {**COMPILED, "NUMBA_DISABLE_JIT": "1"})
    ]
    assert played[0] == played[1], "a stand-in for a phase was kept as compiled code"


def test_the_work_of_a_step_stands_beside_its_rate(run):
    """Ours as the scenario has it."""
    ours = json.loads((run / "bench.json").read_text())["subjects"][0]

    assert (ours["agents"], ours["physics_ticks"], ours["arbiter"]) == (4, "6.25", True)
    assert ours["env_steps_per_cpu_s"] > 0


def test_the_page_keeps_what_is_written_by_hand(run):
    """Only what stands between the marks changes."""
    old = (ROOT / "docs" / "performance.md").read_text()

    assert (run / "page.md").read_text().startswith(old.partition("<!-- made by make bench -->")[0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--only", "everything"), "invalid choice: 'everything'"),
        (("--only", "batch"), "choose from start, peers, ours, limits, phases"),
        (("--against", "HEAD", "--only", "peers"), "choose from batch, threads"),
        (("--pufferlib", "docs"), "docs has no pufferlib/ocean/target/target.h"),
        (("--against", "HEAD", "--page", "README.md"), "README.md must be a page that holds"),
        (("--rounds", 0), "--rounds must be at least 1"),
        (("--json", "README.md/figures.json"), "README.md: cannot be written: is a file, not a folder"),
        (("--page", "README.md"), "README.md must be a page that holds"),
        (("--page", "no.md"), "no.md must be a page"),
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
    """Every row but the starts, which need the compiler; with uncommitted changes, which the tables tell of."""
    shutil.copy(ROOT / "docs" / "performance.md", tmp_path / "page.md")
    rows = ("batch", "threads", "hunters", "controls", "one-arena", "memory")
    done = repository.bench("HEAD", "--only", *rows, "--json", tmp_path / "bench.json", "--page", tmp_path / "page.md")
    assert done.returncode == 0, done.stderr

    figures = json.loads((tmp_path / "bench.json").read_text())
    page = (tmp_path / "page.md").read_text()
    assert figures["commit"] == repository.git("rev-parse", "HEAD").strip()
    assert figures["before"]["cpu"].keys() == figures["after"]["cpu"].keys()
    assert {len(rounds) for what, rounds in figures["after"]["cpu"].items() if what != "memory"} == {2}
    assert "with changes that are not committed" in page
    for what in ("batch of 1,024, ns an agent-step", "one arena, full control, us a step", "memory, bytes an arena"):
        assert f"| {what}" in page
    for what in ("two threads beside one", "64 hunters", "velocity control beside", "full control beside"):
        assert re.search(rf"\| [^|]*{what}[^|]* \|[^|]+\|[^|]+\| +wanted [^|]+: (met|missed) \|", page)
    assert page.startswith((ROOT / "docs" / "performance.md").read_text().partition("<!-- made by scripts/bench")[0])
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

    assert re.fullmatch(r"bench: --against needs .*, and \S*unpacked is no git checkout\n", unpacked.stderr)
    assert without.stderr == "bench: --against needs git, which is not installed here\n"
    assert unpacked.returncode == without.returncode == 1


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_leaves_no_checkout_and_no_process_behind(repository, number):
    """While it measures."""
    command = [sys.executable, "scripts/bench", "--against", "HEAD", "--quick", "--only", "hunters"]
    with subprocess.Popen(
        command, cwd=repository.folder, env=repository.environment, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr.readline() == "compiling both versions\n"
        sides = children_of(process.pid)
        process.send_signal(number)
        _, words = process.communicate(timeout=240)

    assert process.returncode == 130
    assert words.splitlines()[-1] == "bench: interrupted"
    assert repository.left() == []
    assert len(sides) == 2
    assert not any(Path("/proc", side).exists() for side in sides)


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
    puffer = module("puffer", monkeypatch)
    header = tmp_path / puffer.HEADER
    header.parent.mkdir(parents=True)
    header.write_text(HEADER)
    driver = puffer.Driver(tmp_path)
    play = driver.batch(envs=100, agents=4, goals=14, steps=5)
    play()
    play()
    names = ("begun", "played", "least_turn", "most_turn", "least_push", "most_push")
    assert [ctypes.c_int.in_dll(driver.library, name).value for name in names] == [100, 1000, 0, 8, 0, 4]

    header.write_text("no C at all")
    with pytest.raises(RuntimeError, match=r"^pufferlib/ocean/target/target\.h:1:1: error"):
        puffer.Driver(tmp_path)


def test_a_batch_whose_phases_are_measured_plays_by_what_it_is_given(monkeypatch):
    """A stand-in that nobody plays would make every phase cost nothing."""
    phases, played = module("phases", monkeypatch), []
    engine = catch_arena.Engine(catch_arena.scenario("standard"), 2)
    engine.reset(range(2))
    phases.play_by(engine, lambda *given: played.append(given))
    engine.step(np.ones((2, 4), dtype=np.int64), np.zeros((2, 4, 2), dtype=np.float32))
    assert len(played) == 1


@pytest.mark.parametrize("arenas", [8, 2048])
def test_the_memory_of_a_batch_is_counted_whoever_it_is_asked_of(arenas, monkeypatch):
    """Large batches have pages of their own, of which tracemalloc hears nothing."""
    of_an_arena = module("ours", monkeypatch).bytes_of_an_arena(arenas)
    batch = catch_arena.VectorArena("standard", arenas)
    assert batch.reset(seed=1)[0].nbytes / arenas < of_an_arena < 50_000
