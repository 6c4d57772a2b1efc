"""What people are told while the rules are compiled."""

import time
from types import SimpleNamespace

import numba
import pytest

from catch_arena.core.jit import INTERPRETED
from catch_arena.engine import compiling


def ended(name):
    """Numba's event: a function was compiled."""
    return SimpleNamespace(data={"dispatcher": SimpleNamespace(py_func=SimpleNamespace(__qualname__=name))})


@pytest.fixture
def now(monkeypatch):
    """A clock that is set."""
    clock = SimpleNamespace(s=100.0)
    monkeypatch.setattr(time, "monotonic", lambda: clock.s)
    return clock


def test_the_machine_s_own_speed_replaces_the_first_guess(now):
    """Half of the functions in 15 s, and then 40 % of the time for all together."""
    clock = compiling.CompileClock({"a", "b", "c", "d"}, None)
    assert (clock.elapsed_s, clock.total_s) == (0.0, 20.0)
    clock.on_start(None)
    now.s += 15.0
    for name in ("a", "somebody else's", "a", "b"):
        clock.on_end(ended(name))
    assert clock.elapsed_s == 15.0
    assert clock.total_s == pytest.approx(15.0 / 0.5 / 0.6)


def test_what_the_last_time_took_is_believed_until_it_is_over(now):
    """Never is more done than there is; and where it takes longer, this machine's own speed counts again."""
    clock = compiling.CompileClock({"a", "b"}, 12.5)
    clock.on_start(None)
    now.s += 9.0
    clock.on_end(ended("a"))
    assert clock.total_s == 12.5
    now.s += 9.0
    assert clock.total_s == 18.0
    clock.on_end(ended("b"))
    assert clock.total_s == pytest.approx(18.0 / 0.6)


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
def test_only_who_waits_for_the_compiler_is_told(tmp_path, monkeypatch, capsys):
    """Not who calls what was compiled before; and it is remembered how long it took."""
    monkeypatch.setattr(compiling, "_QUIET_S", 1e-6)
    monkeypatch.setattr(compiling, "_FRAME_S", 0.001)
    monkeypatch.setattr(compiling, "_NOTE", tmp_path / "took")

    @numba.njit
    def add_one(value):
        return value + 1

    assert compiling._last_time_s() is None
    with compiling.progress_shown():
        assert add_one(1) == 2
    line = capsys.readouterr().err
    assert line.startswith("catch_arena: compiling the rules for this machine (")
    assert line.endswith("about 20 s)\n")
    assert compiling._last_time_s() is not None
    with compiling.progress_shown():
        assert add_one(2) == 3
    assert capsys.readouterr().err == ""
