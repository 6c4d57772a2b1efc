"""Every way to fail is a real agent in bad/: it forfeits with its code, the others play on, and nothing is left."""

import re
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import pytest
from isolation_levels import LEVELS

from catch_arena import Replay, scenario
from catch_arena.descendants import family
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.playing import inspector, start_players
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match_loop import play

BAD = Path(__file__).parent / "bad"
SHORT = scenario("duel", time_limit_s=4)
PATIENT = AgentLimits(init_s=60, step_ms=60_000)
"""For agents that fail in other ways than by being late: a busy machine must not make them late."""
IMPATIENT = {
    "hangs": AgentLimits(init_s=60, step_ms=1000, bank_s=3.0),
    "hangs_at_import": AgentLimits(init_s=1),
    "never_reads.sh": AgentLimits(init_s=6),
}

NAPS = """
import time
naps = {}

class Agent:
    def reset(self, seed):
        pass

    def act(self, view):
        time.sleep(naps.pop() if naps else 0)
        return 0
"""


@pytest.fixture(scope="module", params=LEVELS)
def sandbox(request):
    with Sandbox(replace(PATIENT, isolation=request.param)) as made:
        yield made


def entered(sandbox, name, *others):
    path = BAD / name
    first = f"cmd:sh {path}" if path.suffix == ".sh" else f"{path}.py"
    return enter([first, *(others or ["nearest"])], inspector(sandbox))


def played(sandbox, name, *others, record=None):
    entrants = entered(sandbox, name, *others)
    config = SHORT.replace(hunters=len(entrants))
    with start_players(entrants, sandbox) as players:
        return play(config, 3, players, [one.name for one in entrants], record=record)


@pytest.mark.parametrize(
    ("name", "code", "step", "reason"),
    [
        ("crashes", "FORFEIT_CRASH", 5, "act raised ZeroDivisionError: integer division or modulo by zero"),
        ("exits", "FORFEIT_CRASH", 5, "act: its process exited with code 3"),
        ("closes_its_answers", "FORFEIT_CRASH", 1, "act: its process exited with code 1"),
        (
            "hangs",
            "FORFEIT_TIMEOUT",
            5,
            r"act took longer than step_ms \(1000 ms\) and what was left of bank_s \(3 s\)",
        ),
        ("never_reads.sh", "FORFEIT_INIT", 0, r"reset took longer than what was left of init_s \(6 s\)"),
        ("hangs_at_import", "FORFEIT_INIT", 0, r"init took longer than init_s \(1 s\)"),
        (
            "speaks_garbage",
            "FORFEIT_ILLEGAL",
            1,
            "said more than one line: 'no JSON|its line is no JSON object: 'no JSON'",
        ),
        ("floods_the_answers", "FORFEIT_ILLEGAL", 1, "its line is longer than 65536 bytes"),
        ("answers_twice.sh", "FORFEIT_ILLEGAL", 1, "said more than one line"),
        ("is_illegal", "FORFEIT_ILLEGAL", 1, "an action must be a whole number from 0 to 8, got 99"),
        ("hoards", "FORFEIT_CRASH", 5, "act raised MemoryError"),
        ("maps", "FORFEIT_CRASH", 5, "act raised OSError: .*Cannot allocate memory"),
        ("opens_files", "FORFEIT_CRASH", 5, "act raised OSError: .*Too many open files"),
        ("writes_much", "FORFEIT_CRASH", 5, "act raised OSError: .*File too large"),
    ],
)
def test_it_forfeits_with_its_code_comes_last_and_the_other_plays_on(sandbox, tmp_path, name, code, step, reason):
    within_limits = replace(IMPATIENT.get(name, PATIENT), isolation=sandbox.level)
    with Sandbox(within_limits) if name in IMPATIENT else nullcontext(sandbox) as within:
        result = played(within, name, record=tmp_path / "m.replay")
    assert result.forfeits == (code, None)
    assert result.details[0].step == step
    assert re.match(reason, result.details[0].reason), result.details[0].reason
    assert "\n" not in result.details[0].reason
    assert result.ranks == (2, 1)
    assert result.steps == 40
    assert result.thinking[1].moves == 40
    replay = Replay.load(tmp_path / "m.replay")
    assert replay.withdrawals == [(max(0, step - 1), 0)]
    *_, last = replay.worlds()
    assert last.hunters[0].withdrawn
    assert last.hunters[1].score == result.scores[1] > 0


def test_one_that_kills_the_program_above_it_forfeits(sandbox):
    result = played(sandbox, "kills_its_parent")
    assert str(result.details[0]) == "FORFEIT_CRASH in step 1: act: its process has ended"


def test_who_is_late_stays_late_though_another_thinks_for_longer(sandbox, tmp_path):
    """The first takes longer than what is left of its bank, and answers before the second does."""
    for name, naps in (("late", "[4.2, 1.0]"), ("slow", "[4.4, 0.0]")):
        (tmp_path / f"{name}.py").write_text(NAPS.format(naps))
    with Sandbox(AgentLimits(init_s=60, step_ms=200, bank_s=4.5, isolation=sandbox.level)) as within:
        entrants = enter([str(tmp_path / "late.py"), str(tmp_path / "slow.py")], inspector(within))
        with start_players(entrants, within) as players:
            result = play(SHORT, 3, players, ["late", "slow"], most_steps=3)
    assert str(result.details[0]).startswith("FORFEIT_TIMEOUT in step 2")


def test_a_traceback_goes_to_the_agents_own_log(sandbox):
    result = played(sandbox, "crashes")
    assert "bad/crashes.py" in result.logs[0]
    assert result.logs[0].endswith("ZeroDivisionError: integer division or modulo by zero\n")
    assert result.logs[1] == ""


def test_what_it_prints_is_kept_from_the_beginning_and_the_end_and_costs_it_nothing_else(sandbox):
    result = played(sandbox, "prints_without_end")
    assert result.forfeits == (None, None)
    assert len(result.logs[0]) < 66_000
    assert result.logs[0].startswith("the first line\nxxx")
    assert result.logs[0].endswith("xxxthe end of step 3\n")
    assert re.search(r"\n\[\d+ bytes left out\]\n", result.logs[0])


@pytest.mark.parametrize("level", LEVELS)
def test_what_it_takes_over_a_step_comes_out_of_its_bank(level):
    """50 ms a step at least, of which 10 are allowed: a bank of 0.2 s lasts for 5 steps at most."""
    limits = AgentLimits(init_s=60, step_ms=10, bank_s=0.2, isolation=level)
    with Sandbox(limits) as sandbox:
        result = played(sandbox, "is_slow")
    assert result.forfeits[0] == "FORFEIT_TIMEOUT"
    assert result.details[0].step <= 6
    spent = result.thinking[0]
    assert spent.total_s - spent.moves * limits.step_ms / 1000 > limits.bank_s  # and not before


@pytest.mark.parametrize("level", LEVELS)
def test_cpu_time_is_limited_too(level):
    with Sandbox(AgentLimits(init_s=60, step_ms=600_000, cpu_s=1, isolation=level)) as sandbox:
        result = played(sandbox, "hangs")
    assert result.forfeits == ("FORFEIT_CRASH", None)
    assert result.details[0].reason == "act: its process used up its CPU time (cpu_s)"


def test_a_child_that_would_outlive_its_parent_does_not(sandbox):
    result = played(sandbox, "leaves_a_child")
    assert result.forfeits == (None, None)
    assert re.match(r"child \d+", result.logs[0])
    below = 2 if sandbox.level == "namespaces" else 0  # bubblewrap's first process, and the agent's program
    assert len(family(*sandbox.pids)) == below * len(sandbox.pids)


def test_what_it_writes_goes_to_a_folder_of_its_own_that_is_removed(sandbox, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = played(sandbox, "writes_here")
    assert result.forfeits == (None, None)
    (folder,) = re.findall(r"folder (.*)", result.logs[0])
    assert not Path(folder).exists()
    if sandbox.level == "processes":
        assert Path(folder).parent.exists()
    assert not list(tmp_path.iterdir())


def test_it_finds_nothing_of_the_match_or_its_rival_in_its_memory(sandbox):
    result = played(sandbox, "spies")
    assert result.forfeits == (None, None)
    assert "found [] open 5 " in result.logs[0]
    assert "'PYTEST_CURRENT_TEST'" not in result.logs[0]


def test_the_same_agent_finds_all_of_it_where_it_is_trusted(capsys):
    result = played(None, "spies")
    assert result.forfeits == ("FORFEIT_ILLEGAL", None)
    assert re.search(r"found \[.*'CatchArenaEnv', 'Engine'.*'the rival'\]", capsys.readouterr().out)


def test_nothing_is_carried_from_one_match_to_the_next(sandbox):
    entrants = entered(sandbox, "remembers")
    for _ in range(2):
        with start_players(entrants, sandbox) as players:
            assert play(SHORT, 1, players, ["a", "b"]).logs[0] == "made 1 1 1\n"


def test_those_who_forfeit_come_behind_all_others_and_the_longer_they_lasted_the_better(sandbox):
    result = played(sandbox, "crashes", str(BAD / "is_illegal.py"), "idle", str(BAD / "hoards.py"))
    assert result.forfeits == ("FORFEIT_CRASH", "FORFEIT_ILLEGAL", None, "FORFEIT_CRASH")
    assert result.ranks == (2, 4, 1, 2)


def test_a_match_ends_when_all_have_forfeited(sandbox):
    result = played(sandbox, "crashes", str(BAD / "is_illegal.py"))
    assert result.forfeits == ("FORFEIT_CRASH", "FORFEIT_ILLEGAL")
    assert result.steps == 5
    assert result.ranks == (1, 2)


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        ("class Agent\n", "importing it raised SyntaxError"),
        ("import os\nos._exit(1)\n", "init: its process"),
        ("class Agnet: pass\n", "has no class Agent; did you mean Agnet"),
        (
            "class Agent:\n    def reset(self, seed): pass\n    def act(self): pass\n",
            r"must take one argument: def act",
        ),
        ("class Agent:\n    def __init__(self): 1 / 0\n", r"Agent\(\) raised ZeroDivisionError"),
        ("class Agent:\n    control = 'fly'\n", "must have a method reset"),
    ],
)
def test_one_that_cannot_begin_is_entered_and_forfeits_every_match(sandbox, tmp_path, source, reason):
    path = tmp_path / "mine.py"
    path.write_text(source)
    entrants = enter([str(path), "nearest"], inspector(sandbox))
    assert re.search(reason, entrants[0].fault)
    with start_players(entrants, sandbox) as players:
        result = play(SHORT, 1, players, ["mine", "nearest"])
    assert result.forfeits == ("FORFEIT_INIT", None)
    assert result.details[0].reason == entrants[0].fault
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["mine.py"]


def test_the_traceback_of_one_that_cannot_be_imported_begins_with_its_own_line(sandbox, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text("def share():\n    return 1 / 0\n\nshare()\n")
    log = inspector(sandbox)(str(path)).log
    assert "importlib" not in log
    assert "entrants.py" not in log
    assert re.findall(r"line (\d+), in (\S+)", log) == [("4", "<module>"), ("2", "share")]


def test_of_an_error_of_ours_the_log_has_the_agent_s_own_lines(sandbox, tmp_path):
    """The error is a line that tells all; the lines of ours that raised it tell a student nothing."""
    (tmp_path / "mine.npz").write_bytes(b"damaged")
    path = tmp_path / "mine.py"
    path.write_text(
        "from catch_arena.training import Mlp\n\n\nclass Agent:\n    def __init__(self):\n"
        f"        Mlp.load({str(tmp_path / 'mine.npz')!r})\n"
    )
    found = inspector(sandbox)(str(path))
    assert "mine.npz: must be what Mlp.save writes" in str(found.fault)
    assert re.findall(r'File ".*/(\w+\.py)", line (\d+)', found.log) == [("mine.py", "6")]
    assert "ConfigError" not in found.log


@pytest.mark.parametrize("name", ["crashes", "is_illegal"])
def test_a_trusted_agent_that_fails_forfeits_too(name):
    result = played(None, name)
    assert result.forfeits[0] in {"FORFEIT_CRASH", "FORFEIT_ILLEGAL"}
    assert result.ranks == (2, 1)
    assert result.steps == 40
