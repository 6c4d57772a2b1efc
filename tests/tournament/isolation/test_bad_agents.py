"""An agent that fails forfeits with the right code at each level of isolation, and the other agents play on."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from isolation_levels import LEVELS
from tournament.agents import LEAVES_A_CHILD, source

from catch_arena import Replay, scenario
from catch_arena.interrupts import descendants
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match_loop import play_entrants
from catch_arena.tournament.players import enter

BAD = Path(__file__).parent / "bad"
SHORT = scenario("duel", time_limit_s=4)
PATIENT = Quotas(init_s=60, step_ms=60_000)
"""For agents that fail in other ways than by being late: a busy machine must not make them late."""
SHELL = """while read -r line; do
    case $line in
        *hello*) echo '{"control":"target"}' ;;
        *reset*) echo '{"ready":true}' ;;
        *) printf '%s' ;;
    esac
done
"""
WRITES_TO_ALL = """
for file in range(3, 64):
    with suppress(OSError):  # not open, or not to be written
        os.write(file, %s)
"""
FLOODS = "while True:" + WRITES_TO_ALL.replace("\n", "\n    ") % "bytes(4096)"
WRITES_BEFORE = "import os\nfrom contextlib import suppress\n"


def in_step_5(line, before=""):
    return source(f"if self.step == 5:\n    {line}\nreturn 0", before=before)


AGENTS = {
    **{path.stem: path.read_text() for path in BAD.glob("*.py")},
    "closes_its_answers": source("os.closerange(0, 64)\nreturn 0", before="import os\n"),
    "never_reads.sh": 'echo \'{"control":"target"}\'\nsleep 3600\n',
    "hangs_at_import": source(before="import time\ntime.sleep(3600)\n"),
    "speaks_garbage": source(WRITES_TO_ALL % r"b'no JSON\n'", before=WRITES_BEFORE),
    "floods_the_answers": source(FLOODS, before=WRITES_BEFORE),
    "says_goodbye": in_step_5("print('goodbye'); os._exit(3)", before="import os\n"),
    "dies.sh": SHELL.replace("printf '%s'", "echo goodbye >&2; exit 3"),
    "answers_twice.sh": SHELL % r'{"action":0}\n{"action":0}\n',
    "is_illegal": source("return 99"),
    "is_endless": source("return 10**5000"),
    "hoards": in_step_5("self.hoard = bytearray(2 << 30)"),
    "maps": in_step_5("self.hoard = mmap.mmap(-1, 8 << 30)", "import mmap\n"),
    "opens_files": in_step_5("self.files = [open('/dev/null') for _ in range(1000)]"),
    "writes_much": in_step_5("open('much', 'wb').write(bytes(100 << 20))"),
    "kills_its_parent": source("os.kill(os.getppid(), 9)\ntime.sleep(1)\nreturn 0", before="import os, time\n"),
    "leaves_a_child": source(reset=LEAVES_A_CHILD, before="import os\n"),
    "is_slow": source("time.sleep(0.05)\nreturn 0", before="import time\n"),
    "prints_without_end": source(
        "print('x' * 250_000, 'the end of step', self.step)\nreturn 0",
        "print('the first line')",
    ),
    "spies": source(
        "kinds = {type(thing).__name__ for thing in gc.get_objects()}\n"
        "found = sorted(kinds & {'CatchArenaEnv', 'Engine', 'Sandbox', 'ArenaConfig'})\n"
        "found += ['the rival'] * ('catch_arena.agents.nearest' in sys.modules)\n"
        "print('found', found, 'open', len(os.listdir('/proc/self/fd')) - 1)\n"
        "return 99 if found else 0",
        before="import gc, os, sys\n",
    ),
}
"""Sources by name; those in bad/ are files, since other tests play them too."""


@pytest.fixture(scope="module", params=LEVELS)
def sandbox(request):
    with Sandbox(replace(PATIENT, isolation=request.param)) as made:
        yield made


@pytest.fixture
def played(tmp_path):
    """Plays a match of these agents."""
    folder = tmp_path / "agents"
    folder.mkdir()

    def spec(name):
        if name not in AGENTS:
            return name
        path = folder / (name if name.endswith(".sh") else f"{name}.py")
        path.write_text(AGENTS[name])
        return f"cmd:sh {path}" if name.endswith(".sh") else str(path)

    def match(sandbox, *names, record=None):
        entrants = enter(list(map(spec, names)), sandbox)
        config = SHORT.replace(hunters=len(entrants))
        return play_entrants(config, 3, entrants, sandbox, record=record)

    return match


@pytest.mark.parametrize(
    ("name", "limits", "code", "step", "reason"),
    [
        ("crashes", {}, "FORFEIT_CRASH", 5, "act raised ZeroDivisionError: integer division or modulo by zero"),
        ("exits", {}, "FORFEIT_CRASH", 5, "act: its process exited with code 3"),
        ("says_goodbye", {}, "FORFEIT_CRASH", 5, 'act: its process exited with code 3; its last line: "goodbye"'),
        ("dies.sh", {}, "FORFEIT_CRASH", 1, 'act: its process exited with code 3; its last line: "goodbye"'),
        ("closes_its_answers", {}, "FORFEIT_CRASH", 1, "act: its process exited with code 1"),
        (
            "hangs",
            {"step_ms": 1000, "bank_s": 3.0},
            "FORFEIT_TIMEOUT",
            5,
            r"act took longer than step_ms \(1000 ms\) and what was left of bank_s \(3 s\)",
        ),
        ("hangs", {"cpu_s": 1}, "FORFEIT_CRASH", 5, r"act: its process used up its CPU time \(cpu_s\)"),
        ("never_reads.sh", {"init_s": 3}, "FORFEIT_INIT", 0, r"reset took longer than what was left of init_s \(3 s\)"),
        ("hangs_at_import", {"init_s": 1}, "FORFEIT_INIT", 0, r"init took longer than init_s \(1 s\)"),
        ("speaks_garbage", {}, "FORFEIT_ILLEGAL", 1, "(said more than one line|its line is no JSON object): 'no JSON"),
        ("floods_the_answers", {}, "FORFEIT_ILLEGAL", 1, "its line is longer than 65536 bytes"),
        ("answers_twice.sh", {}, "FORFEIT_ILLEGAL", 1, "said more than one line"),
        ("is_illegal", {}, "FORFEIT_ILLEGAL", 1, "an action must be a whole number from 0 to 8, got 99"),
        ("is_endless", {}, "FORFEIT_ILLEGAL", 1, "an action must be a whole number from 0 to 8"),
        ("hoards", {}, "FORFEIT_CRASH", 5, "act raised MemoryError"),
        ("maps", {}, "FORFEIT_CRASH", 5, "act raised OSError: .*Cannot allocate memory"),
        ("opens_files", {}, "FORFEIT_CRASH", 5, "act raised OSError: .*Too many open files"),
        ("writes_much", {}, "FORFEIT_CRASH", 5, "act raised OSError: .*File too large"),
        ("kills_its_parent", {}, "FORFEIT_CRASH", 1, "act: its process was ended by SIGKILL"),
    ],
)
def test_it_forfeits_with_its_code_comes_last_and_the_other_plays_on(
    sandbox, played, tmp_path, name, limits, code, step, reason
):
    with Sandbox(replace(PATIENT, isolation=sandbox.quotas.isolation, **limits)) as within:
        result = played(within if limits else sandbox, name, "nearest", record=tmp_path / "m.replay")
    assert result.forfeit_codes == (code, None)
    assert result.forfeits[0].step == step
    assert re.match(reason, result.forfeits[0].reason), result.forfeits[0].reason
    assert "\n" not in result.forfeits[0].reason
    assert result.ranks == (2, 1)
    assert result.steps == result.thinking[1].moves == 40
    replay = Replay.load(tmp_path / "m.replay")
    assert replay.withdrawals == [(max(0, step - 1), 0)]
    *_, last = replay.worlds()
    assert last.hunters[0].withdrawn
    assert last.hunters[1].score == result.scores[1] > 0


def test_what_it_takes_over_a_step_comes_out_of_its_bank(sandbox, played):
    """50 ms a step at least, of which 10 are allowed: a bank of 0.2 s lasts for 5 steps at most."""
    with Sandbox(Quotas(init_s=60, step_ms=10, bank_s=0.2, isolation=sandbox.quotas.isolation)) as within:
        result = played(within, "is_slow", "nearest")
    assert result.forfeit_codes[0] == "FORFEIT_TIMEOUT"
    assert result.forfeits[0].step <= 6
    spent = result.thinking[0]
    assert spent.total_s - spent.moves * 0.01 > 0.2  # and not before


def test_what_it_prints_is_kept_from_the_beginning_and_the_end_up_to_a_limit(sandbox, played):
    result = played(sandbox, "prints_without_end", "nearest")
    assert result.forfeit_codes == (None, None)
    assert len(result.logs[0]) < 66_000
    assert result.logs[0].startswith("the first line\nxxx")
    assert result.logs[0].endswith("xxx the end of step 40\n")
    assert re.search(r"\n\[\d+ bytes left out\]\n", result.logs[0])
    assert result.logs[1] == ""
    with Sandbox(replace(PATIENT, file_mib=1, isolation=sandbox.quotas.isolation)) as within:
        result = played(within, "prints_without_end", "nearest")
    assert str(result.forfeits[0]) == "FORFEIT_CRASH in step 5: printed more than 1 MiB: print less (file_mib)"
    assert result.logs[0].endswith("xxx the end of step 5\n")


REPLACES = "sys.stdout.close(); sys.stdout = open('/dev/null', 'w')"


@pytest.mark.parametrize("closing", ["sys.stdout.close()", "sys.stderr.close()", "sys.stdout.detach()", REPLACES])
def test_one_that_prints_nowhere_plays_on(sandbox, tmp_path, closing):
    prints = "sys.stdout is usual or print('start')"
    (tmp_path / "quiet.py").write_text(source(reset=prints, before=f"import sys\nusual = sys.stdout\n{closing}\n"))
    entrants = enter([str(tmp_path / "quiet.py"), "idle"], sandbox)
    assert play_entrants(SHORT, 1, entrants, sandbox).forfeit_codes == (None, None)


def test_a_child_that_would_outlive_its_parent_does_not(sandbox, played):
    assert played(sandbox, "leaves_a_child", "nearest").forfeit_codes == (None, None)
    below = 2 if sandbox.quotas.isolation == "namespaces" else 0  # bubblewrap's first process, and the agent's program
    pids = [process.pid for process in sandbox._waiting]
    assert len(descendants(*pids)) == below * len(pids)


def test_what_it_writes_goes_to_a_folder_of_its_own_that_is_removed(sandbox, played, tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    result = played(sandbox, "writes_here", "nearest")
    assert result.forfeit_codes == (None, None)
    (folder,) = re.findall(r"folder (.*)", result.logs[0])
    assert not Path(folder).exists()
    assert not list((tmp_path / "here").iterdir())


def test_it_finds_nothing_of_the_match_or_its_rival_in_its_memory(sandbox, played, capsys):
    """A trusted one finds all of it."""
    assert "found [] open 5\n" in played(sandbox, "spies", "nearest").logs[0]
    assert played(None, "spies", "nearest").forfeit_codes == ("FORFEIT_ILLEGAL", None)
    assert re.search(r"found \[.*'CatchArenaEnv', 'Engine'.*'the rival'\]", capsys.readouterr().out)


@pytest.mark.parametrize("trusted", [True, False])
def test_a_match_ends_when_all_have_forfeited(sandbox, played, trusted):
    result = played(None if trusted else sandbox, "crashes", "is_illegal")
    assert result.forfeit_codes == ("FORFEIT_CRASH", "FORFEIT_ILLEGAL")
    assert (result.steps, result.ranks) == (5, (1, 2))


EXITS = "import os\nos.write(2, b'hello\\nlast line\\n')\nos._exit(7)\n"


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        ("class Agnet: pass\n", "mine.py: has no class Agent; did you mean Agnet?"),
        ("class Agent:\n    def __init__(self): 1 / 0\n", "Agent() raised ZeroDivisionError: division by zero"),
        (EXITS, 'init: its process exited with code 7; its last line: "last line"'),
        ("import ctypes\nctypes.string_at(0)\n", "init: its process was ended by SIGSEGV"),
        ("raise KeyboardInterrupt\n", 'init: its process exited with code 1; its last line: "KeyboardInterrupt"'),
        (
            "class Agent:\n    def __init__(self): raise KeyboardInterrupt\n",
            'init: its process exited with code 1; its last line: "KeyboardInterrupt"',
        ),
        ("import os, time\nos.closerange(3, 64)\ntime.sleep(600)\n", "init: it closed its answers"),
        ("cmd:sh -c 'echo last line >&2; exit 3'", 'init: its process exited with code 3; its last line: "last line"'),
        ("cmd:sh -c 'kill -6 $$'", "init: its process was ended by SIGABRT"),
        ("cmd:sh -c 'exit 255'", "init: its process exited with code 255"),
    ],
)
def test_one_that_cannot_begin_is_entered_and_forfeits_with_the_reason_and_its_output_is_kept(
    sandbox, tmp_path, source, reason
):
    path = tmp_path / "mine.py"
    path.write_text(source)
    entrants = enter([source if source.startswith("cmd:") else str(path), "idle"], sandbox)
    assert entrants[0].fault.endswith(reason)
    result = play_entrants(SHORT, 1, entrants, sandbox)
    assert result.forfeit_codes == ("FORFEIT_INIT", None)
    assert result.forfeits[0].reason == entrants[0].fault
    _, _, last_line = reason.partition("its last line: ")
    assert result.logs[0].endswith(last_line.strip('"'))
    assert result.logs[0].startswith("hello\n") == (source is EXITS)
    assert [entry.name for entry in tmp_path.iterdir()] == ["mine.py"]
