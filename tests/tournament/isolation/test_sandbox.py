"""Isolated and trusted agents play the same match, and a failure of ours is never an agent's forfeit."""

import os
import signal
import time
from dataclasses import fields, replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from isolation_levels import LEVELS
from tournament.agents import write_agent

import catch_arena.agents
from catch_arena import scenario
from catch_arena.errors import ConfigError, MatchFailedError
from catch_arena.interrupts import descendants
from catch_arena.policy import Limits
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.loading import shipped
from catch_arena.tournament.match_loop import MatchStopped, play_entrants, play_match
from catch_arena.tournament.players import Players, enter

SHORT = scenario("duel", time_limit_s=10)


@pytest.fixture(scope="module", params=LEVELS)
def sandbox(request):
    with Sandbox(Quotas(isolation=request.param)) as made:
        yield made


def alone(name):
    """A shipped agent, as a file: it would be trusted under its name."""
    return str(Path(catch_arena.agents.__path__[0]) / f"{name}.py")


def played(config, entrants, sandbox, **options):
    return play_entrants(config, 7, entrants, sandbox, **options)


def test_isolated_and_trusted_play_agree_in_every_bit(sandbox):
    names = [*shipped(), "random"]
    config = scenario("standard", hunters=len(names), time_limit_s=6)
    isolated = played(config, enter([alone(name) for name in names], sandbox), sandbox)
    mixed = played(config, enter([alone(name) for name in names[:3]] + names[3:], sandbox), sandbox)
    trusted = played(config, enter(names), None)
    assert isolated == mixed == trusted
    assert isolated.forfeit_codes == (None,) * len(names)


def test_agents_that_come_with_the_package_need_no_process(sandbox):
    sandbox.close()
    before = descendants(os.getpid())  # Python's own helpers may have been started by other tests
    played(SHORT, enter(["nearest", "catch_arena.agents.idle:Agent"], sandbox), sandbox)
    assert descendants(os.getpid()) == before
    played(SHORT, enter(["nearest", alone("idle")], sandbox), sandbox)
    # in namespaces: bubblewrap, its first process, and the program of the agent
    of_each = 3 if sandbox.quotas.isolation == "namespaces" else 1
    assert len(descendants(os.getpid()) - before) == of_each


def test_an_entrant_is_the_same_however_it_was_looked_at(sandbox, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text("from catch_arena.agents.patrol import Agent\nfrom catch_arena.agents.flee import Prey\n")
    words = ["patrol", "catch_arena.agents.first:Agent", str(path)]
    assert enter(words, sandbox) == enter(words)


def test_an_agent_plays_with_the_control_of_its_check_whatever_it_says_later(sandbox, tmp_path):
    drives = write_agent(tmp_path / "drives.py", "return 1.0, 0.5")
    results = []
    for within in (sandbox, None):
        first, *others = enter([drives, "idle"], within)
        assert first.control == "target"
        results.append(played(SHORT, [replace(first, control="velocity"), *others], within))
    assert results[0].forfeit_codes == (None, None)
    assert results[0] == results[1]


DRIVES = """while read -r line; do
    case $line in
        *hello*) echo '{"control":"velocity"}' ;;
        *) echo '{"action":[1.0,0.5]}' ;;
    esac
done
"""


def test_a_command_plays_from_the_folder_that_it_was_named_in(sandbox, tmp_path, monkeypatch):
    """Agents work in another folder. This one drives: velocities are actions of any language."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "drives.sh").write_text(DRIVES)
    entrants = enter(["cmd:sh drives.sh", "idle"], sandbox)
    monkeypatch.chdir("/")
    assert (entrants[0].control, entrants[0].fault) == ("velocity", None)
    assert played(SHORT, entrants, sandbox).forfeit_codes == (None, None)


def test_a_file_that_no_system_can_start_is_a_fault(sandbox, tmp_path):
    program = tmp_path / "bot"
    program.write_text("no program\n")
    program.chmod(0o755)
    (entrant,) = enter([f"cmd:{program}"], sandbox)
    hint = "a script's first line must name its interpreter, such as #!/bin/sh"
    assert entrant.fault.endswith(f"bot: cannot be started: Exec format error; {hint}")


def test_an_agent_is_told_its_own_seed_and_the_arenas_limits(sandbox, tmp_path):
    act = "print(view.limits, view.observation[:2])\nreturn 0"
    entrants = enter([write_agent(tmp_path / "prints.py", act, "print('seed', seed)"), "idle"], sandbox)
    result = played(SHORT, entrants, sandbox, agent_seeds=(2**63 - 1, 1))
    assert result.logs[0].startswith(f"seed {2**63 - 1}\n{Limits.of(SHORT)} [")


def test_a_module_is_imported_once_for_all_matches_and_what_a_match_changes_is_gone(sandbox, tmp_path):
    """Be it in the module, in the class or in its working folder."""
    before = "from pathlib import Path\nprint('imported')\nmatches = []\n"
    reset = (
        "matches.append(1)\nAgent.step += 1\nPath('file').open('a').write('x')\n"
        "print(len(matches), Agent.step, len(Path('file').read_text()))"
    )
    entrants = enter([write_agent(tmp_path / "mine.py", reset=reset, before=before), "idle"], sandbox)
    first, second = (played(SHORT, entrants, sandbox).logs[0].splitlines() for _ in range(2))
    assert first in (["1 1 1"], ["imported", "1 1 1"])  # it was imported when it was looked at, or for the first match
    assert second == ["1 1 1"]


def test_all_are_asked_at_the_same_time(tmp_path):
    """Each answers when all four have seen their views: asked one after the other, the first would be late."""
    before = "import os, time\nfrom pathlib import Path\nHERE = Path(__file__).parent\n"
    act = (
        "(HERE / f'{self.step}-{os.getpid()}').touch()\n"
        "while len(list(HERE.glob(f'{self.step}-*'))) < 4: time.sleep(0.005)\nreturn 0"
    )
    path = write_agent(tmp_path / "waits.py", act, before=before)
    with Sandbox(Quotas(step_ms=120_000, isolation="processes")) as patient:  # where it may write next to its file
        entrants = enter([path] * 4, patient)
        result = played(scenario("standard", time_limit_s=0.3), entrants, patient)
    assert result.forfeit_codes == (None,) * 4
    assert len(list(tmp_path.glob("3-*"))) == 4


def test_the_docs_have_every_limit():
    page = (Path(__file__).parents[3] / "docs" / "howto" / "isolation.md").read_text()
    for limit in fields(Quotas):
        if limit.name in Quotas().numbers():
            assert f"| `{limit.name}` | {limit.default:g} |" in page


def test_a_process_that_cannot_start_is_no_contest_and_its_last_line_says_why(sandbox, monkeypatch):
    """Here the program that all agents run in: it ends before it has run any of an agent's code."""
    entrants = enter([alone("nearest"), alone("idle")], sandbox)
    sandbox.close()
    with monkeypatch.context() as changed:
        changed.setattr("catch_arena.tournament.isolation.sandbox._MAIN", "raise SystemExit('no room')")
        with pytest.raises(MatchFailedError, match=r"the process of (nearest|idle) could not start: no room"):
            played(SHORT, entrants, sandbox)
    assert played(SHORT, entrants, sandbox).forfeit_codes == (None, None)


def test_without_a_folder_for_temporary_files_nothing_begins_and_no_agent_is_blamed(monkeypatch):
    def nowhere(**_):
        raise FileNotFoundError(2, "No usable temporary directory found")

    monkeypatch.setattr("catch_arena.tournament.isolation.sandbox.tempfile.TemporaryDirectory", nowhere)
    with (
        Sandbox(Quotas(isolation="processes")) as sandbox,
        pytest.raises(MatchFailedError) as raised,
    ):
        enter([alone("nearest")], sandbox)
    why = "No usable temporary directory found: set TMPDIR to a writable folder"
    assert str(raised.value) == f"an agent's process cannot be started: {why}"


def test_a_match_in_which_we_stood_still_ourselves_is_no_contest(sandbox, tmp_path, monkeypatch):
    monkeypatch.setattr("catch_arena.tournament.players._STALL_S", 1.0)
    slow = write_agent(tmp_path / "slow.py", "time.sleep(0.05)\nreturn 0", before="import time\n")
    entrants = enter([slow, "idle"], sandbox)
    former = signal.signal(signal.SIGALRM, lambda *_: time.sleep(1.5))
    try:
        with (
            pytest.raises(MatchFailedError, match="this process stood still for"),
            Players(entrants, sandbox) as players,
        ):
            # the alarm comes 20 ms after a step's begin: while the slow one is waited for
            play_match(SHORT, 1, players, ["a", "b"], watch=lambda _: signal.setitimer(signal.ITIMER_REAL, 0.02))
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, former)


def test_no_agent_pays_for_what_is_done_while_waiting_for_it(sandbox, tmp_path, monkeypatch):
    """Each call takes longer than the agent's limit, by a clock of the test, and longer than a stall of our process."""
    monkeypatch.setattr("catch_arena.tournament.players._STALL_S", 50.0)
    drawing_s = [0.0]
    clock = SimpleNamespace(monotonic=lambda: time.monotonic() + sum(drawing_s), perf_counter=time.perf_counter)
    slow = write_agent(tmp_path / "slow.py", "time.sleep(0.3)\nreturn 0", before="import time\n")
    with Sandbox(Quotas(isolation=sandbox.quotas.isolation, step_ms=60_000, bank_s=0)) as patient:
        entrants = enter([slow, "idle"], patient)
        with Players(entrants, patient, while_waiting=lambda: drawing_s.append(100.0)) as players:
            monkeypatch.setattr("catch_arena.tournament.players.time", clock)
            result = play_match(SHORT, 1, players, ["a", "b"], most_steps=1)
    assert result.forfeit_codes == (None, None)
    assert result.thinking[0].longest_s < 60


def test_a_match_may_be_stopped_while_an_agent_hangs(sandbox, tmp_path):
    """The output that it printed before is kept."""
    hangs = write_agent(tmp_path / "hangs.py", "print('step', self.step)\ntime.sleep(600)", before="import time\n")
    calls = []

    def stop():
        calls.append(time.monotonic())
        if len(calls) == 3:
            raise MatchStopped

    with Sandbox(Quotas(isolation=sandbox.quotas.isolation, step_ms=600_000)) as patient:
        entrants = enter([hangs, alone("idle")], patient)
        with Players(entrants, patient, while_waiting=stop) as players:
            result = play_match(SHORT, 1, players, ["a", "b"])
    assert result.forfeit_codes == (None, None)
    assert result.logs == ("step 1\n", "")
    assert len(calls) == 3


def test_players_that_begin_again_have_no_more_processes(sandbox):
    """As when a ROS arena restarts its match."""
    entrants = enter([alone("idle"), alone("first")], sandbox)
    limits = [Limits.of(SHORT, seat) for seat in range(2)]
    counts = []
    with Players(entrants, sandbox) as players:
        for seed in range(3):
            assert players.reset([seed, seed], limits) == {}
            counts.append(len(descendants(os.getpid())))
    assert len(set(counts)) == 1


def test_an_interrupt_ends_all_agents_and_the_next_match_starts_anew(sandbox):
    sandbox.close()
    before = descendants(os.getpid())
    entrants = enter([alone("nearest"), alone("idle")], sandbox)

    def interrupt(env):
        if env.world().step == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        played(SHORT, entrants, sandbox, watch=interrupt)
    assert descendants(os.getpid()) == before
    assert played(SHORT, entrants, sandbox).forfeit_codes == (None, None)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"step_ms": 0}, "step_ms must be a number from 1 to 1000000, got 0"),
        ({"memory_mib": 1.5}, "memory_mib must be a whole number from 32 to 1000000, got 1.5"),
        ({"init_s": True}, "init_s must be a number"),
        ({"step": 3}, "unknown limit 'step': did you mean step_ms"),
        ({"isolation": "namespace"}, "isolation must be one of namespaces, processes, got 'namespace'"),
    ],
)
def test_limits_that_cannot_be_are_named(values, message):
    with pytest.raises(ConfigError, match=message):
        Quotas.of(**values)
