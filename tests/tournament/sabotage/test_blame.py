"""No agent stops a tournament: whoever does harm is named and forfeits, and all others come out as if it had simply
forfeited.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from tournament.sabotage.saboteurs import forfeiter, saboteur

import catch_arena.agents
from catch_arena.descendants import family
from catch_arena.tournament.match import MatchResult
from catch_arena.tournament.store import Store

pytestmark = pytest.mark.hostile
HONEST = ("nearest", "contested", "first")
"""Shipped ones, as files: they would be trusted under their names."""
QUICK = (
    "--scenario",
    "duel",
    "--set",
    "time_limit_s=3",
    "--limit",
    "init_s=60",
    "--limit",
    "step_ms=20000",
    "--isolation",
    "processes",
    "--seed",
    "7",
)
"""Patient, since a busy machine must not make anybody late."""
SABOTAGE = "FORFEIT_SABOTAGE"


def honest(folder: Path, count: int = 2) -> list[str]:
    paths = [folder / f"my_{name}.py" for name in HONEST[:count]]
    for name, path in zip(HONEST, paths, strict=False):
        shutil.copy(Path(catch_arena.agents.__path__[0]) / f"{name}.py", path)
    return [str(path) for path in paths]


def play(folder: Path, agents, *words: str, lives: int = 1, env=None) -> subprocess.CompletedProcess:
    """The tournament of these agents, resumed until it ends: it may be ended `lives` times at most."""
    command = [
        sys.executable,
        "-m",
        "catch_arena",
        "tournament",
        *agents,
        "--rounds",
        "1",
        *QUICK,
        "--out",
        str(folder),
        *words,
    ]
    for _ in range(lives):
        done = subprocess.run(
            [*command, "--resume"], check=False, capture_output=True, text=True, timeout=900, env=env, cwd=Path.cwd()
        )
        if done.returncode == 0:
            return done
    raise AssertionError(done.stderr)


def results(folder: Path) -> tuple[list[str], list[tuple[tuple[int, ...], MatchResult]]]:
    with Store.read(folder) as store:
        names = [one.name for one in store.tournament.entrants]
        return names, [(one.match.seating, one.result) for one in store.played()]


def codes(folder: Path) -> dict[str, set[str | None]]:
    """How each agent forfeited, None for a match that it played to its end."""
    names, played = results(folder)
    found: dict[str, set[str | None]] = {name: set() for name in names}
    for seating, result in played:
        for index, code in zip(seating, result.forfeits, strict=True):
            found[names[index]].add(code)
    return found


def of_the_honest(folder: Path) -> list[tuple]:
    """What each honest agent made of each of its matches."""
    names, played = results(folder)
    return [
        (number, seat, names[index], result.scores[seat], result.ranks[seat], result.verdicts[seat], result.steps)
        for number, (seating, result) in enumerate(played)
        for seat, index in enumerate(seating)
        if names[index].startswith("my_")
    ]


def require_as_if_they_forfeited(tmp_path: Path, kinds) -> None:
    agents = [*(forfeiter(tmp_path, kind) for kind in kinds), *honest(tmp_path)]
    play(tmp_path / "expected", agents, "--max-forfeits", "0")
    assert of_the_honest(tmp_path / "o") == of_the_honest(tmp_path / "expected")


NIGHTLY = pytest.mark.nightly


@pytest.mark.parametrize(
    "kind",
    [
        pytest.param("at_reset", marks=NIGHTLY),
        "in_a_step",
        pytest.param("all_but_the_tournament", marks=NIGHTLY),
        pytest.param("its_rivals", marks=NIGHTLY),
        pytest.param("stops_the_supervisor", marks=NIGHTLY),
        pytest.param("stops_the_worker", marks=NIGHTLY),
        "leaves_an_orphan",
    ],
)
def test_the_culprit_is_named_and_forfeits_and_the_others_come_out_as_without_it(tmp_path, kind):
    others = honest(tmp_path)
    done = play(tmp_path / "o", [saboteur(tmp_path, kind), *others], "--jobs", "2")
    found = codes(tmp_path / "o")
    assert found.pop(kind) == {SABOTAGE}
    assert set(map(frozenset, found.values())) == {frozenset({None})}
    assert f"{kind} did harm, and forfeited 4 matches for it (FORFEIT_SABOTAGE)" in done.stdout
    assert "while no other agent ran" in (tmp_path / "o" / "report.html").read_text()
    assert "FORFEIT_SABOTAGE before the first step" in (tmp_path / "o" / "logs" / f"{kind}.log").read_text()
    require_as_if_they_forfeited(tmp_path, [kind])


@pytest.mark.parametrize("kind", ["at_import", pytest.param("at_construction", marks=NIGHTLY)])
def test_one_that_does_harm_when_it_is_looked_at_is_not_started(tmp_path, kind):
    others = honest(tmp_path)
    done = play(tmp_path / "o", [saboteur(tmp_path, kind), *others])
    assert f"warning: {kind} cannot begin, and forfeits its matches: it did harm when it was looked at" in done.stderr
    assert codes(tmp_path / "o") == {kind: {"FORFEIT_INIT"}} | {Path(path).stem: {None} for path in others}


def test_one_that_kills_the_tournament_when_it_is_looked_at_is_not_looked_at_again(tmp_path):
    others = honest(tmp_path)
    done = play(tmp_path / "o", [saboteur(tmp_path, "the_tournament_at_import"), *others], "--jobs", "1", lives=2)
    said = "the tournament was killed while it was looked at; to have it looked at again, remove inspections.json"
    assert f"cannot begin, and forfeits its matches: {said}" in done.stderr
    assert codes(tmp_path / "o") == {"the_tournament_at_import": {"FORFEIT_INIT"}} | {
        Path(path).stem: {None} for path in others
    }


@pytest.mark.parametrize("kind", [pytest.param("by_a_sleeping_grandchild", marks=NIGHTLY), "by_a_thread_that_waits"])
def test_who_plays_when_another_ones_harm_is_done_is_not_blamed(tmp_path, kind):
    """The one waits until its match is over, and is ended with it; the other strikes where it has no seat."""
    others = honest(tmp_path, 3)
    play(tmp_path / "o", [saboteur(tmp_path, kind), *others], "--jobs", "1", "--set", "time_limit_s=10")
    found = codes(tmp_path / "o")
    assert found.pop(kind) <= {None, SABOTAGE, "FORFEIT_OUT"}
    assert set(map(frozenset, found.values())) == {frozenset({None})}


@pytest.mark.parametrize(
    ("kind", "lives"), [("the_tournament", 4), pytest.param("interrupts_the_tournament", 6, marks=NIGHTLY)]
)
def test_a_tournament_that_is_killed_goes_on_and_meets_no_stop_twice(tmp_path, kind, lives):
    """It is killed once where all play at once, then in its turn, in each of two blocks; then it is out. A signal that
    may be a person's counts half.
    """
    others = honest(tmp_path)
    below = saboteur(tmp_path, kind)
    play(tmp_path / "o", [below, *others], "--jobs", "1", lives=lives + 1)
    found = codes(tmp_path / "o")
    assert found.pop(kind) == {SABOTAGE}
    assert set(map(frozenset, found.values())) == {frozenset({None})}
    require_as_if_they_forfeited(tmp_path, [kind])


def test_a_tournament_killed_from_outside_blames_nobody(tmp_path):
    """Its blocks are played again with agents apart, and come out as they would have."""
    agents = honest(tmp_path, 3)
    command = [sys.executable, "-m", "catch_arena", "tournament", *agents, "--rounds", "1", *QUICK, "--jobs", "2"]
    process = subprocess.Popen([*command, "--out", str(tmp_path / "o")], stdout=subprocess.DEVNULL)
    while not (tmp_path / "o" / "tournament.sqlite").exists() or not begun(tmp_path / "o"):
        assert process.poll() is None
    process.kill()
    process.wait()
    play(tmp_path / "o", agents, "--jobs", "2")
    play(tmp_path / "undisturbed", agents, "--jobs", "1")
    assert results(tmp_path / "o") == results(tmp_path / "undisturbed")
    assert not begun(tmp_path / "o")


def begun(folder: Path) -> list[int]:
    try:
        with Store.read(folder) as store, store.transaction() as db:
            return [block for (block,) in db.execute("SELECT block FROM begun")]
    except Exception:  # noqa: BLE001 - it may be half made
        return []


def test_whoever_harms_a_single_match_is_named_there(tmp_path):
    words = [saboteur(tmp_path, "in_a_step"), *honest(tmp_path, 1), *QUICK, "-o", str(tmp_path / "m.replay")]
    command = [sys.executable, "-m", "catch_arena", "match", *words]
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=300)
    assert "in_a_step (hunter_0): FORFEIT_SABOTAGE before the first step: its supervisor was ended" in done.stdout


@pytest.fixture
def small_disk(tmp_path):
    folder = tmp_path / "small"
    folder.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=24m", "tmpfs", folder], check=False, stderr=-3).returncode:
        pytest.skip("only root makes a small disk")
    yield folder
    subprocess.run(["umount", "--lazy", folder], check=True)


def test_whoever_fills_the_disk_of_the_agents_folders_is_named(tmp_path, small_disk):
    """A rival that writes a little fails for want of room, and is not blamed."""
    writes = tmp_path / "writes.py"
    writes.write_text(
        "class Agent:\n    def reset(self, seed): pass\n    def act(self, view):\n"
        "        with open('notes', 'ab') as file: file.write(bytes(4096))\n        return 0\n"
    )
    agents = [saboteur(tmp_path, "fills_the_disk"), str(writes)]
    play(tmp_path / "o", agents, "--jobs", "1", env=os.environ | {"TMPDIR": str(small_disk)})
    assert codes(tmp_path / "o") == {"fills_the_disk": {SABOTAGE}, "writes": {None}}
    reasons = {detail and detail.reason for _, result in results(tmp_path / "o")[1] for detail in result.details}
    assert reasons == {None, "the disk of the agents' folders was filled while no other agent ran"}


@pytest.fixture
def little_memory():
    """A group of processes whose memory is bounded together; what it has to write its processes to."""
    group = Path(f"/sys/fs/cgroup/memory/catch-arena-test-{os.getpid()}")
    try:
        group.mkdir()
        (group / "memory.limit_in_bytes").write_text(str(900 << 20))
    except OSError:
        pytest.skip("only root bounds the memory of a group, and here only in version 1 of control groups")
    yield group
    group.rmdir()


@NIGHTLY
def test_whoever_takes_the_memory_with_many_processes_harms_nobody_else(tmp_path, little_memory):
    """The kernel ends whom it likes: rivals, supervisors, workers."""
    others = honest(tmp_path)
    agents = [saboteur(tmp_path, "takes_the_memory"), *others]
    command = [
        sys.executable,
        "-m",
        "catch_arena",
        "tournament",
        *agents,
        "--rounds",
        "1",
        *QUICK,
        "--jobs",
        "2",
        "--resume",
    ]
    enter = f'echo $$ > {little_memory}/cgroup.procs; exec "$@"'
    for _ in range(5):
        words = ["sh", "-c", enter, "sh", *command, "--out", str(tmp_path / "o")]
        done = subprocess.run(words, check=False, capture_output=True, text=True, timeout=900)
        if done.returncode == 0:
            break
    assert done.returncode == 0, done.stderr
    found = codes(tmp_path / "o")
    assert found.pop("takes_the_memory") <= {SABOTAGE, "FORFEIT_CRASH", "FORFEIT_TIMEOUT", None}
    assert set(map(frozenset, found.values())) == {frozenset({None})}


HOSTILE = ("in_a_step", "all_but_the_tournament", "stops_the_supervisor", "its_rivals", "at_reset")


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """What comes of the tournament whose hostile agents simply forfeit."""
    folder = tmp_path_factory.mktemp("expected")
    agents = [*(forfeiter(folder, kind) for kind in HOSTILE), *honest(folder, 3)]
    play(folder / "o", agents, "--jobs", "2", "--max-forfeits", "0")
    return of_the_honest(folder / "o")


@pytest.mark.parametrize("number", [0, 1, *(pytest.param(one, marks=NIGHTLY) for one in range(2, 20))])
def test_of_eight_agents_five_are_hostile_and_the_table_is_right(tmp_path, expected, number):
    agents = [*(saboteur(tmp_path, kind) for kind in HOSTILE), *honest(tmp_path, 3)]
    before = family(os.getpid())
    play(tmp_path / "o", agents, "--jobs", str(1 + number % 2))
    assert of_the_honest(tmp_path / "o") == expected
    found = codes(tmp_path / "o")
    for kind in HOSTILE:
        assert SABOTAGE in found[kind]
    assert all(found[f"my_{name}"] == {None} for name in HONEST)
    table = json.loads((tmp_path / "o" / "standings.json").read_text())["standings"]
    assert {line["agent"] for line in table[:3]} == {f"my_{name}" for name in HONEST}
    assert family(os.getpid()) == before
