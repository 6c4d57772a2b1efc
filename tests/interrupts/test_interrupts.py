"""Ctrl-C, SIGTERM and a closed terminal end a command with one line, whatever it is doing."""

import os
import pty
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from interrupts.commands import PATIENCE_S, Command

from catch_arena.interrupts import descendants

ROOT = Path(__file__).parents[2]
BEGIN = "import os, signal, subprocess, sys, threading, time\nfrom catch_arena import interrupts\ninterrupts.listen()\n"
BEGUN = "print('begun', flush=True)"
LOOP = "while True: time.sleep(0.01)"
LINE = "catch-arena: interrupted\n"


def started(folder, code: str) -> Command:
    """Start a program that runs this code's `command`, and wait until that has printed."""
    command = Command(folder, (), (sys.executable, "-c", f"{BEGIN}{code}\ninterrupts.run(command)"))
    assert command.process.stdout.readline() == "begun\n"
    return command


def interrupted(folder, code: str, *pauses: float, number: int = signal.SIGINT) -> tuple[int, str, str]:
    """The status, the output and the errors of a command that is interrupted once, and again after each pause [s]."""
    program = started(folder, code)
    program.interrupt(pauses, number)
    end = program.ended()
    assert end.left == []
    return end.status, end.output, end.errors


def command(*lines: str) -> str:
    """Return the code of a command that runs these lines, and prints that it has begun unless these lines do."""
    return "\n    ".join(["def command():", *([] if BEGUN in "".join(lines) else [BEGUN]), *lines])


TRY = ("try:", f"    {BEGUN}", f"    {LOOP}")  # begun within it: an interrupt may come at once

UNWINDS = command(*TRY, "finally:", "    print('tidied up', flush=True)")


@pytest.mark.parametrize(
    ("number", "status", "line"),
    [
        (signal.SIGINT, 130, LINE),
        (signal.SIGTERM, 143, "catch-arena: terminated\n"),
        (signal.SIGHUP, 129, "catch-arena: hung up\n"),
    ],
)
def test_a_signal_unwinds_what_is_under_way(tmp_path, number, status, line):
    former = signal.signal(number, signal.SIG_DFL)  # what is deaf to one, as under nohup, starts programs that are
    try:
        assert interrupted(tmp_path, UNWINDS, number=number) == (status, "tidied up\n", line)
    finally:
        signal.signal(number, former)


BREAKS_A_THREAD = (
    "ends = threading.Event()",
    "threading.Thread(target=lambda: ends.wait() and 1 / 0).start()",
    *TRY,
    "finally:",
    "    ends.set()",
    "    time.sleep(0.2)",
)


@pytest.mark.parametrize(
    "lines",
    [
        ("while True:", "    try:", f"        {LOOP}", "    except BaseException: pass"),
        (*TRY, "finally:", f"    {LOOP}"),
        (*TRY, "except BaseException:", "    raise ImportError('half imported') from None"),
        ("class Held:", "    def __del__(self):", f"        {LOOP}", "held = Held()", "del held", LOOP),
        ("lock = threading.Lock()", "lock.acquire()", "lock.acquire()"),
        ("threading.Thread(target=threading.Event().wait).start()",),
        ("import atexit", "atexit.register(threading.Event().wait)"),
        BREAKS_A_THREAD,
    ],
    ids=[
        *("swallows", "hangs_at_the_end", "another_error", "a_destructor", "a_lock", "a_thread", "at_exit"),
        "a_broken_thread",
    ],
)
def test_whatever_becomes_of_the_interrupt_the_command_ends_with_one_line(tmp_path, lines):
    assert interrupted(tmp_path, command(*lines), 0.01, 0.05) == (130, "", LINE)


def test_all_that_descend_from_it_end_with_it(tmp_path):
    """One ends when it is asked to, and one is deaf to that; each has a child of its own."""
    lines = (
        "for deaf in ('', 'trap \"\" TERM;'):",
        "    shell = ['sh', '-c', f'{deaf} sleep 1000 & echo; wait; sleep 1000']",
        "    subprocess.Popen(shell, stdout=-1, start_new_session=True).stdout.readline()",
        "print('all', flush=True)",
        LOOP,
    )
    program = started(tmp_path, command(*lines))
    assert program.process.stdout.readline() == "all\n"
    assert len(descendants(program.process.pid)) == 4
    program.interrupt()
    end = program.ended()
    assert (end.status, end.errors, end.left) == (130, LINE, [])


def test_the_line_says_more_where_there_is_more_to_say(tmp_path):
    script = command("interrupts.add_to_message('not all is lost')", BEGUN, LOOP)
    assert interrupted(tmp_path, script) == (130, "", "catch-arena: interrupted: not all is lost\n")


def test_what_waits_for_an_interrupt_has_ended_well(tmp_path):
    waits = f"interrupts.wait(lambda: {BEGUN})"
    announces_late = f"interrupts.wait(lambda: ({BEGUN}, time.sleep(9)))"
    for lines in ([waits], [announces_late]):
        assert interrupted(tmp_path, command(*lines)) == (0, "", "")
    assert interrupted(tmp_path, command(waits, "threading.Event().wait()"), 0.1) == (130, "", LINE)


def test_what_may_be_broken_off_is_done_to_its_end_or_to_an_interrupt(tmp_path):
    """Either is the normal end; what comes after it is done too, and an interrupt there is one as ever."""
    after = "print('after', flush=True)"
    lingers = command(f"interrupts.run_until_signal(lambda: ({BEGUN}, time.sleep(60)))", after)
    assert interrupted(tmp_path, lingers) == (0, "after\n", "")
    program = started(tmp_path, command(f"interrupts.run_until_signal(lambda: ({BEGUN}, time.sleep(60)))", after, LOOP))
    program.interrupt()
    assert program.process.stdout.readline() == "after\n"
    program.interrupt()
    end = program.ended()
    assert (end.status, end.output, end.errors) == (130, "", LINE)  # what comes after it was not done to its end
    ends_by_itself = command("interrupts.run_until_signal(lambda: None)", BEGUN, "time.sleep(60)")
    assert interrupted(tmp_path, ends_by_itself) == (130, "", LINE)


@pytest.mark.parametrize(("ends", "status"), [("", 0), ("sys.exit(3)", 3), ("return 2", 2), ("1 / 0", 2)])
def test_without_an_interrupt_it_ends_as_any_program(tmp_path, ends, status):
    program = started(tmp_path, command("import atexit", "atexit.register(print, 'last')", ends))
    end = program.ended()
    assert (end.status, end.output) == (status, "last\n")
    assert ("ZeroDivisionError" in end.errors) == (ends == "1 / 0")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP])
def test_what_was_started_deaf_to_interrupts_stays_so(tmp_path, number):
    """A shell starts background commands so, and nohup those that outlive its terminal."""
    former = signal.signal(number, signal.SIG_IGN)
    try:
        assert interrupted(tmp_path, command("time.sleep(0.5)"), number=number) == (0, "", "")
    finally:
        signal.signal(number, former)


def test_a_hidden_cursor_comes_back(tmp_path):
    """On a terminal, whatever was drawn in the last line gives way to ours."""
    ours, theirs = pty.openpty()
    code = f"{BEGIN}{command(LOOP)}\ninterrupts.run(command)"
    with subprocess.Popen([sys.executable, "-c", code], cwd=tmp_path, stdout=subprocess.PIPE, stderr=theirs) as process:
        os.close(theirs)
        process.stdout.readline()
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE_S) == 130
    assert os.read(ours, 1000) == b"\r\x1b[K\x1b[?25hcatch-arena: interrupted\r\n"
    os.close(ours)


def test_an_interrupt_while_the_commands_are_imported(tmp_path):
    code = (
        "import sys, time\nfrom catch_arena import __main__\nclass Slow:\n    def find_spec(self, name, *_):\n"
        f"        if name == 'typer':\n            {BEGUN}\n            time.sleep(60)\n"
        "sys.meta_path.insert(0, Slow())\n__main__.main()"
    )
    program = Command(tmp_path, ["--help"], (sys.executable, "-c", code))
    assert program.process.stdout.readline() == "begun\n"
    program.interrupt([0.01])
    end = program.ended()
    assert (end.status, end.errors, end.output) == (130, LINE, "")


def test_little_is_imported_before_the_command_hears_ctrl_c():
    """Nothing of setuptools' finder nor of pip's command: a Ctrl-C meanwhile is a traceback."""
    plain = {name: value for name, value in os.environ.items() if not name.startswith("COVERAGE_")}
    command = Path(sys.executable).with_name("catch-arena")
    words = [sys.executable, "-X", "importtime", command, "--version"]
    stderr = subprocess.run(words, check=True, capture_output=True, text=True, env=plain).stderr
    imported = re.findall(r"\| +(\S+)$", stderr, re.MULTILINE)
    before = imported[: imported.index("catch_arena.interrupts")]
    assert "site" in before
    assert {"pathlib", "re"}.isdisjoint(before)
