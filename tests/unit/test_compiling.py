"""What people are told while the rules are compiled, and how often that is done."""

import io
import sys
import threading
import time
from types import SimpleNamespace

import numba
import pytest

from catch_arena.core import compiler
from catch_arena.core.jit import INTERPRETED
from catch_arena.engine import compiling
from catch_arena.engine.compiling import CompileClock, Variant

ONE, BATCH, ALL_FOR_ONE = Variant(batch=False, options=False), Variant(batch=True, options=False), Variant(False, True)


@pytest.fixture
def now(monkeypatch):
    """A clock that is set."""
    clock = SimpleNamespace(s=100.0)
    monkeypatch.setattr(time, "monotonic", lambda: clock.s)
    return clock


@pytest.fixture
def new_process(monkeypatch):
    """Nothing is known, and nothing is compiled."""
    monkeypatch.setattr(CompileClock, "pace", None)
    monkeypatch.setattr(compiling, "_compiled", set())


@pytest.mark.usefixtures("new_process")
def test_the_first_functions_tell_how_long_it_takes_on_this_machine(now):
    """Twice as long as usual; the time before the first, when Numba imports, does not count. Then it stays as it was
    told, so that no bar goes back.
    """
    clock = CompileClock(ONE)
    assert (clock.elapsed_s, clock.total_s) == (0.0, None)
    clock.on_start(None)
    now.s += 3.0
    clock.on_end(None)
    for _ in range(compiling._SAMPLE - 1):
        assert clock.total_s is None
        now.s += 2.0 * compiling._SAMPLE_S / (compiling._SAMPLE - 1)
        clock.on_end(None)
    expected = pytest.approx(2.0 * compiling._COMMON.first_s)
    assert clock.total_s == expected
    now.s += 100.0
    clock.on_end(None)
    assert clock.elapsed_s > 100.0
    assert clock.total_s == expected


@pytest.mark.usefixtures("new_process")
def test_how_long_one_variant_took_tells_how_long_the_next_will_take(now):
    """Three times as long as usual. What is over at once, since most of it was kept, tells nothing."""
    clock = CompileClock(ALL_FOR_ONE)
    clock.on_start(None)
    now.s += 3.0 * compiling._ALL.first_s
    clock.finish()
    assert CompileClock(BATCH).total_s == pytest.approx(3.0 * compiling._COMMON.later_s)
    clock = CompileClock(BATCH)
    clock.on_start(None)
    now.s += 0.1
    clock.finish()
    assert CompileClock.pace == pytest.approx(3.0)


def test_it_is_told_of_each_variant_how_long_it_takes(monkeypatch):
    """The next one of a process shares functions with the first, and all rules are more than the common ones."""
    monkeypatch.setattr(CompileClock, "pace", 2.0)
    common, every = CompileClock(ONE).total_s, CompileClock(ALL_FOR_ONE).total_s
    assert common == 2.0 * compiling._COMMON.later_s < 2.0 * compiling._COMMON.first_s
    assert every == 2.0 * compiling._ALL.later_s > common


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
def test_only_who_waits_for_the_compiler_is_told(monkeypatch, capsys):
    """Not who calls what was compiled before."""
    monkeypatch.setattr(compiling, "_QUIET_S", 1e-6)
    monkeypatch.setattr(compiling, "_FRAME_S", 0.001)
    monkeypatch.setattr(CompileClock, "pace", 10.0)

    @numba.njit
    def add_one(value):
        return value + 1

    with compiling.progress_shown(BATCH):
        assert add_one(1) == 2
    expected_s = 10.0 * compiling._COMMON.later_s
    expected = f"catch_arena: compiling the common rules for a batch (about {expected_s:.0f} s; {compiling._KEPT})\n"
    assert capsys.readouterr().err == expected
    with compiling.progress_shown(BATCH):
        assert add_one(2) == 3
    assert capsys.readouterr().err == ""


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def told(monkeypatch):
    """What is written to a terminal of that kind within 13 s."""

    def write(kind):
        terminal = Terminal()
        clock = SimpleNamespace(elapsed_s=2.0, total_s=8.0)

        def wait(seconds):
            clock.elapsed_s += seconds
            return clock.elapsed_s > 13.0

        monkeypatch.setattr(sys, "stderr", terminal)
        monkeypatch.setenv("TERM", kind)
        compiling._tell(ALL_FOR_ONE, clock, SimpleNamespace(wait=wait))
        return terminal.getvalue()

    return write


def test_a_terminal_that_cannot_move_its_cursor_gets_lines(told):
    first, *others = told("dumb").splitlines()
    assert first.startswith("catch_arena: compiling all rules for one arena (about 8 s; ")
    assert others == ["catch_arena: compiling: 7 of about 8 s", "catch_arena: compiling: 12 s instead of about 8"]


def test_a_terminal_gets_a_bar(told):
    text = told("xterm")
    assert "one arena (about 8 s; " in text
    assert text.index(" 2 of about 8 s") < text.index(" 8 of about 8 s") < text.index(" 12 s instead of about 8")


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
@pytest.mark.usefixtures("new_process")
def test_what_was_interrupted_is_compiled_as_if_for_the_first_time(monkeypatch):
    """Ctrl-C in a notebook, and the same call again: it is told again, and Numba is quick again; and only once."""
    shown = []
    progress_shown = compiling.progress_shown
    monkeypatch.setattr(compiling, "progress_shown", lambda variant: shown.append(variant) or progress_shown(variant))
    slow = compiler.types.functions.BaseFunction.get_call_type
    plays = []

    def play():
        compiling.compile_once(ONE, play)  # as the engine that is played does
        plays.append(compiler.types.functions.BaseFunction.get_call_type is not slow)
        if len(plays) == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        compiling.compile_once(ONE, play)
    for _ in range(2):
        compiling.compile_once(ONE, play)
    assert plays == [True, True]
    assert shown == [ONE, ONE]


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
@pytest.mark.usefixtures("new_process")
def test_a_second_thread_waits_for_the_first():
    """It plays what nobody has compiled yet when the first is over, and nothing twice."""
    began, order = threading.Event(), []

    def in_another_thread():
        began.set()
        compiling.compile_once(ONE, lambda: order.append("the same"))
        compiling.compile_once(BATCH, lambda: order.append("another"))

    thread = threading.Thread(target=in_another_thread)

    def play():
        thread.start()
        began.wait()
        thread.join(0.2)
        order.append("first")

    compiling.compile_once(ONE, play)
    thread.join()
    assert order == ["first", "another"]
