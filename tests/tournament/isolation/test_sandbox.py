"""Isolated play: equal to trusted play in every bit, open to any language; where we fail, no agent is blamed."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from isolation_levels import LEVELS

import catch_arena.agents
from catch_arena import scenario
from catch_arena.descendants import family
from catch_arena.errors import AgentError, ConfigError, NoContest
from catch_arena.policy import Limits
from catch_arena.tournament.entrants import enter, shipped
from catch_arena.tournament.isolation import protocol
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.playing import inspector, start_players
from catch_arena.tournament.isolation.sandbox import Log, Sandbox
from catch_arena.tournament.match_loop import play

HERE = Path(__file__).parent
SHORT = scenario("duel", time_limit_s=10)


@pytest.fixture(scope="module", params=LEVELS)
def sandbox(request):
    with Sandbox(AgentLimits(isolation=request.param)) as made:
        yield made


def alone(name):
    """A shipped agent, as a file: it would be trusted under its name."""
    return str(Path(catch_arena.agents.__path__[0]) / f"{name}.py")


def played(config, entrants, sandbox, **options):
    with start_players(entrants, sandbox) as players:
        return play(config, 7, players, [one.name for one in entrants], **options)


def test_isolated_and_trusted_play_agree_in_every_bit(sandbox):
    names = [*shipped(), "random"]
    config = scenario("standard", hunters=len(names), time_limit_s=15)
    isolated = played(config, enter([alone(name) for name in names], inspector(sandbox)), sandbox)
    mixed = played(config, enter([alone(name) for name in names[:3]] + names[3:], inspector(sandbox)), sandbox)
    trusted = played(config, enter(names), None)
    assert isolated == mixed == trusted
    assert isolated.forfeits == (None,) * len(names)


MULTIPLIED = """
import zlib
import numpy as np
one, other = (np.random.default_rng(seed).normal(size=(64, 64)).astype(np.float32) for seed in (1, 2))
print(zlib.crc32(one @ other))
class Agent:
    def reset(self, seed): pass
    def act(self, view): return 0
"""
"""An agent whose log tells the last bits of a product."""
ISOLATED = """
import sys
from tournament.isolation.test_sandbox import *
with Sandbox(AgentLimits(isolation="processes", init_s=120, bank_s=120)) as sandbox:
    entrants = enter([sys.argv[1], "nearest"], inspector(sandbox))
    print(played(scenario("duel", time_limit_s=1), entrants, sandbox).logs[0])
"""


def test_the_instructions_that_numpy_is_told_to_use_are_an_agents_too(tmp_path):
    """By others a sum has other last bits, and an isolated network would play otherwise than one that is not."""
    (tmp_path / "agent.py").write_text(MULTIPLIED)
    for core in ("Prescott", "Haswell"):
        environment = os.environ | {"OPENBLAS_CORETYPE": core, "PYTHONPATH": str(HERE.parents[1])}
        told = [
            subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.split()
            for command in ([sys.executable, "-c", MULTIPLIED], [sys.executable, "-c", ISOLATED, tmp_path / "agent.py"])
        ]
        assert told[0] == told[1][:1], core


def test_agents_that_come_with_the_package_need_no_process(sandbox):
    sandbox.close()
    before = family(os.getpid())  # Python's own helpers may have been started by other tests
    played(SHORT, enter(["nearest", "catch_arena.agents.idle:Agent"], inspector(sandbox)), sandbox)
    assert family(os.getpid()) == before
    played(SHORT, enter(["nearest", alone("idle")], inspector(sandbox)), sandbox)
    of_each = 3 if sandbox.level == "namespaces" else 1  # bubblewrap, its first process, and the agent's program
    assert len(family(os.getpid()) - before) == of_each


def test_an_entrant_is_the_same_however_it_was_looked_at(sandbox):
    words = ["patrol", "catch_arena.agents.first:Agent", str(HERE / "bad" / "is_slow.py")]
    assert enter(words, inspector(sandbox)) == enter(words)


@pytest.mark.parametrize(
    ("command", "control", "least"), [("sh nearest.sh", "target", 3), ("sh straight.sh", "velocity", 1)]
)
def test_any_language_plays(sandbox, monkeypatch, command, control, least):
    """The files are named from the folder that the tournament is started in; agents work in another one."""
    monkeypatch.chdir(HERE)
    entrants = enter([f"cmd:{command}", "idle"], inspector(sandbox))
    monkeypatch.chdir("/")
    assert (entrants[0].control, entrants[0].fault) == (control, None)
    result = played(scenario("duel", time_limit_s=20), entrants, sandbox)
    assert result.forfeits == (None, None)
    assert result.scores[0] >= least
    assert result.ranks == (1, 2)


def test_the_shells_nearest_is_pythons_nearest(sandbox):
    shell = enter([f"cmd:sh {HERE / 'nearest.sh'}", "idle"], inspector(sandbox))
    python = enter([alone("nearest"), alone("idle")], inspector(sandbox))
    assert played(SHORT, shell, sandbox) == played(SHORT, python, sandbox)


def test_a_commands_name_and_digest_come_from_its_file(sandbox, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    source = (HERE / "nearest.sh").read_text()
    Path("mine.sh").write_text(source)
    Path("other").mkdir()
    Path("other/mine.sh").write_text(source)
    look = inspector(sandbox)
    (mine,) = enter(["cmd:sh mine.sh"], look)
    (same,) = enter([f"cmd:sh {tmp_path}/other/mine.sh"], look)
    (with_option,) = enter(["cmd:sh mine.sh --fast"], look)
    Path("mine.sh").write_text(source + "# changed\n")
    (changed,) = enter(["cmd:sh mine.sh"], look)
    assert mine.name == same.name == changed.name == "mine"
    assert mine.digest == same.digest
    assert len({mine.digest, with_option.digest, changed.digest}) == 3


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("cmd:", "must name a command"),
        ("cmd:'open", "No closing quotation"),
        ("cmd:no_such_program --x", "no_such_program is no program that can be run"),
    ],
)
def test_a_command_that_cannot_be_is_refused(sandbox, word, message):
    with pytest.raises(AgentError, match=message):
        enter([word], inspector(sandbox))


def test_a_command_is_never_trusted():
    with pytest.raises(AgentError, match="a command plays in a process of its own only"):
        enter([f"cmd:sh {HERE / 'nearest.sh'}"])


def test_a_file_that_no_system_can_start_is_a_fault(sandbox, tmp_path):
    program = tmp_path / "bot"
    program.write_text("no program\n")
    program.chmod(0o755)
    (entrant,) = enter([f"cmd:{program}"], inspector(sandbox))
    assert "bot: cannot be started: Exec format error" in entrant.fault


def test_an_agent_is_told_its_own_seed_and_the_arenas_limits(sandbox, tmp_path):
    path = tmp_path / "tells.py"
    path.write_text(
        "class Agent:\n    def reset(self, seed): print('seed', seed)\n"
        "    def act(self, view):\n        print(view.limits, view.observation[:2])\n        return 0\n"
    )
    entrants = enter([str(path), "idle"], inspector(sandbox))
    result = played(SHORT, entrants, sandbox, agent_seeds=(2**63 - 1, 1))
    assert result.logs[0].startswith(f"seed {2**63 - 1}\n{Limits.of(SHORT)} [")


def test_a_module_is_imported_once_for_all_matches_and_what_a_match_changes_in_it_is_gone(sandbox, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(
        "print('imported')\nmatches = 0\nclass Agent:\n    def reset(self, seed):\n        global matches\n"
        "        matches += 1\n        print('match', matches)\n    def act(self, view): return 0\n"
        "class Prey:\n    def reset(self, seed): pass\n    def act(self, view): return [0.0, 0.0]\n"
    )
    entrants = enter([str(path), "idle"], inspector(sandbox))
    first, second = (played(SHORT, entrants, sandbox).logs[0].splitlines() for _ in range(2))
    assert first in (["match 1"], ["imported", "match 1"])  # it may have been looked at in another fork server
    assert second == ["match 1"]


def test_numpys_numbers_are_actions(sandbox, tmp_path):
    path = tmp_path / "numbers.py"
    path.write_text(
        "import numpy as np\nclass Agent:\n    control = 'full'\n    def reset(self, seed): pass\n"
        "    def act(self, view):\n        seen = np.asarray(view.observation, dtype=np.float32)\n"
        "        return {'cmd_vel': np.tanh(seen[10:12]), 'catch': np.int64(view.mask[1])}\n"
    )
    words = [str(path), "nearest"]
    isolated = played(SHORT, enter(words, inspector(sandbox)), sandbox)
    assert isolated == played(SHORT, enter(words), None)
    assert isolated.forfeits == (None, None)


def test_the_docs_have_every_limit():
    page = (HERE.parents[2] / "docs" / "isolation.md").read_text()
    for limit in fields(AgentLimits):
        if limit.name in AgentLimits().numbers():
            assert f"| `{limit.name}` | {limit.default:g} |" in page


def test_all_are_asked_at_once(tmp_path):
    """Each answers when all four have seen their views: asked one after the other, the first would be late."""
    path = tmp_path / "waits.py"
    path.write_text(
        "import os, time\nfrom pathlib import Path\nHERE = Path(__file__).parent\nclass Agent:\n"
        "    def reset(self, seed): self.step = 0\n"
        "    def act(self, view):\n        self.step += 1\n"
        "        (HERE / f'{self.step}-{os.getpid()}').touch()\n"
        "        while len(list(HERE.glob(f'{self.step}-*'))) < 4: time.sleep(0.005)\n        return 0\n"
    )
    config = scenario("standard", time_limit_s=0.3)
    with Sandbox(AgentLimits(step_ms=120_000, isolation="processes")) as patient:  # where it may write beside itself
        result = played(config, enter([str(path)] * 4, inspector(patient)), patient)
    assert result.forfeits == (None,) * 4
    assert len(list(tmp_path.glob("3-*"))) == 4


def test_an_end_that_a_match_has_not_read_does_not_reach_the_next_one(sandbox):
    """A match's process that ends by itself after its last answer leaves it in the pipe."""
    entrants = enter([alone("nearest"), alone("idle")], inspector(sandbox))
    first = played(SHORT, entrants, sandbox)
    for process in sandbox._processes.values():
        assert process.write(protocol.END)
    assert played(SHORT, entrants, sandbox) == first


def test_a_process_that_cannot_start_is_no_contest_and_its_last_line_says_why(sandbox, monkeypatch):
    """Here the program that all agents run in: it ends before it has run any of an agent's code."""
    entrants = enter([alone("nearest"), alone("idle")], inspector(sandbox))
    sandbox.close()
    with monkeypatch.context() as changed:
        changed.setattr("catch_arena.tournament.isolation.sandbox._MAIN", "raise SystemExit('no room')")
        with pytest.raises(NoContest, match=r"the process of (nearest|idle) could not start: no room"):
            played(SHORT, entrants, sandbox)
    assert played(SHORT, entrants, sandbox).forfeits == (None, None)


def test_without_a_folder_for_temporary_files_nothing_begins_and_no_agent_is_blamed(monkeypatch):
    def nowhere(**_):
        raise FileNotFoundError(2, "No usable temporary directory found")

    monkeypatch.setattr("catch_arena.tournament.isolation.sandbox.tempfile.TemporaryDirectory", nowhere)
    with (
        Sandbox(AgentLimits(isolation="processes")) as sandbox,
        pytest.raises(NoContest, match=r"an agent's process cannot be started: .*No usable temporary directory"),
    ):
        enter([alone("nearest")], inspector(sandbox))


def test_a_match_in_which_we_stood_still_ourselves_is_no_contest(sandbox, monkeypatch):
    monkeypatch.setattr("catch_arena.tournament.isolation.isolated_players._STALL_S", 1.0)
    entrants = enter([str(HERE / "bad" / "is_slow.py"), "idle"], inspector(sandbox))
    former = signal.signal(signal.SIGALRM, lambda *_: time.sleep(1.5))
    try:
        with (
            pytest.raises(NoContest, match="this process stood still for"),
            start_players(entrants, sandbox) as players,
        ):
            # the alarm comes 20 ms after a step's begin: while the slow one is waited for
            play(SHORT, 1, players, ["a", "b"], watch=lambda _: signal.setitimer(signal.ITIMER_REAL, 0.02))
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, former)


def test_an_agents_program_removes_its_folder_when_its_pipes_close(tmp_path):
    """The pipes of a tournament that is killed close before the system sends its agents a signal."""
    (folder := tmp_path / "folder").mkdir()
    (lines, into), (answers, out) = os.pipe(), os.pipe()
    told = {"spec": alone("idle"), "limits": AgentLimits().numbers(), "folder": str(folder), "into": lines, "out": out}
    code = "import sys; from catch_arena.tournament.isolation.agent_program import main; main(sys.argv[1])"
    words = [sys.executable, "-c", code, json.dumps(told | {"namespaced": False})]
    with subprocess.Popen(words, pass_fds=(lines, out), stderr=subprocess.DEVNULL):
        os.close(lines)
        os.close(out)
        os.write(into, protocol.hello_line("hunter"))
        with os.fdopen(answers, "rb") as said:
            assert said.readline() == protocol.STARTED
            assert b"control" in said.readline()  # the match's process waits for the next line
            assert folder.exists()
        os.close(into)
    assert not folder.exists()


@pytest.mark.parametrize("level", LEVELS)
def test_nothing_outlives_a_tournament_that_is_killed(level, tmp_path):
    """Not even a grandchild in a session of its own, nor the folders."""
    agent = HERE / "bad" / "leaves_a_child.py"
    code = (
        "from catch_arena import scenario\n"
        "from catch_arena.tournament.entrants import enter\n"
        "from catch_arena.tournament.isolation.playing import inspector, start_players\n"
        "from catch_arena.tournament.match_loop import play\n"
        "from catch_arena.tournament.isolation.limits import AgentLimits\n"
        "from catch_arena.tournament.isolation.sandbox import Sandbox\n"
        f"sandbox = Sandbox(AgentLimits(isolation={level!r}, init_s=120, bank_s=120))\n"
        f"entrants = enter([{str(agent)!r}, {alone('idle')!r}], inspector(sandbox))\n"
        "with start_players(entrants, sandbox) as players:\n"
        "    def tell(env):\n"
        "        if env.world().step == 3:\n"
        "            print(players.logs()[0].strip(), flush=True)\n"
        "            input()\n"
        "    play(scenario('duel'), 1, players, ['a', 'b'], watch=tell)\n"
    )
    (tmp_path / "temporary").mkdir()
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"TMPDIR": str(tmp_path / "temporary")},
    )
    with process:
        _, child = process.stdout.readline().split()
        relatives = family(process.pid)
        if level == "processes":  # in namespaces it has another number, and no folder outside
            assert int(child) in relatives
            assert len(list((tmp_path / "temporary").iterdir())) == 2
        assert len(relatives) >= 5  # two programs, two agents, the child
        process.kill()
    patience = time.monotonic() + 60
    while (any(map(lives, relatives)) or any((tmp_path / "temporary").iterdir())) and time.monotonic() < patience:
        time.sleep(0.02)
    assert not [pid for pid in relatives if lives(pid)]
    assert not any((tmp_path / "temporary").iterdir())


def lives(pid):
    """Return whether a process has not ended; one that nobody has waited for yet has."""
    try:
        return Path(f"/proc/{pid}/stat").read_bytes().rpartition(b")")[2].split()[0] not in {b"Z", b"X"}
    except FileNotFoundError:
        return False


def test_an_interrupt_ends_all_agents_and_the_next_match_starts_anew(sandbox):
    sandbox.close()
    before = family(os.getpid())
    entrants = enter([alone("nearest"), alone("idle")], inspector(sandbox))

    def interrupt(env):
        if env.world().step == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        played(SHORT, entrants, sandbox, watch=interrupt)
    assert family(os.getpid()) == before
    assert played(SHORT, entrants, sandbox).forfeits == (None, None)


def test_a_line_and_a_record_give_every_float32_back():
    bits = np.random.default_rng(1).integers(0, 2**32, 20_000, dtype=np.uint32)
    floats = bits.view(np.float32)
    numbers = [float(number) for number in floats[np.isfinite(floats)]]
    said = json.loads(protocol.view_line(numbers, [1, 0]))
    assert np.asarray(said["view"], dtype=np.float32).tolist() == numbers
    assert said["mask"] == [1, 0]
    reader, writer = os.pipe()
    for number in range(0, len(numbers), 5000):
        some = numbers[number : number + 5000]
        os.write(writer, protocol.view_record(some, [1, 0]))
        assert protocol.read_record(reader) == (some, [1, 0])
    os.write(writer, protocol.view_record([0.5], []))
    assert protocol.read_record(reader) == ([0.5], [])
    os.write(writer, protocol.END)
    assert protocol.read_record(reader) is None
    os.close(writer)
    assert protocol.read_record(reader) is None
    os.close(reader)


def test_a_log_keeps_both_ends():
    log = Log(10)
    log.add(b"abcdefg")
    assert log.text() == "abcdefg"
    log.add(b"hijklmnopq")
    assert log.text() == "abcde\n[7 bytes left out]\nmnopq"


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"step_ms": 0}, "step_ms must be a number from 1 to 1000000, got 0"),
        ({"memory_mib": 1.5}, "memory_mib must be a whole number from 32 to 1000000, got 1.5"),
        ({"init_s": True}, "init_s must be a number"),
        ({"step": 3}, "unknown limit 'step': did you mean step_ms"),
    ],
)
def test_limits_that_cannot_be_are_named(values, message):
    with pytest.raises(ConfigError, match=message):
        AgentLimits.of(**values)
