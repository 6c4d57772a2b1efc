"""The best level of isolation that works here is used; if one does not work, a line says why."""

import os
import stat

import pytest
from isolation_levels import LEVELS, NAMESPACES

from catch_arena.errors import ConfigError
from catch_arena.tournament.isolation import namespaces
from catch_arena.tournament.isolation.namespaces import available_level, level_line
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox


@pytest.fixture
def bubblewrap(tmp_path, monkeypatch):
    """Puts a program of that name before all others; or none at all."""

    def install(script):
        monkeypatch.setenv("PATH", str(tmp_path) if script is None else f"{tmp_path}:{os.environ['PATH']}")
        if script is not None:
            program = tmp_path / "bwrap"
            program.write_text(f"#!/bin/sh\n{script}\n")
            program.chmod(program.stat().st_mode | stat.S_IXUSR)

    return install


def test_the_best_level_holds_unless_another_one_is_asked_for():
    assert available_level() == LEVELS[0]
    for level in LEVELS:
        assert available_level(level) == level


@pytest.mark.parametrize(
    ("script", "why"),
    [
        (None, "bubblewrap is not installed: apt-get install bubblewrap"),
        ("echo bwrap: something is broken >&2; exit 1", "bwrap fails: bwrap: something is broken"),
        ("exit 3", "bwrap fails: exit code 3"),
        ("echo bwrap: Unknown option --disable-userns >&2; exit 1", "it must be version 0.8 or later"),
        ("exec sleep 600", "bwrap does not end"),
        ("kill -9 $$", "bwrap fails: "),
    ],
)
def test_without_a_bubblewrap_that_works_the_level_is_refused_in_one_line(bubblewrap, monkeypatch, script, why):
    bubblewrap(script)
    monkeypatch.setattr(namespaces, "_PROBE_S", 1.0 if script == "exec sleep 600" else 60.0)
    assert available_level() == "processes"
    with pytest.raises(ConfigError) as refused:
        Sandbox(Quotas(isolation="namespaces"))
    assert str(refused.value).startswith("isolation namespaces cannot be held here: ")
    assert why in str(refused.value)
    assert "\n" not in str(refused.value)


def test_one_line_says_what_processes_do_not_stop_and_what_to_install(bubblewrap):
    bubblewrap(None)
    assert level_line("processes") == (
        "isolation: processes, which does not stop a hostile agent: bubblewrap is not installed: apt-get install "
        "bubblewrap, or your system's package of that name (`catch-arena docs isolation`)"
    )


@pytest.mark.skipif(not NAMESPACES, reason="without bubblewrap the line says what to install")
def test_one_line_says_that_a_lower_level_was_chosen():
    assert level_line("processes") == (
        "isolation: processes, which does not stop a hostile agent: namespaces would; "
        "--limit isolation=processes chose this level (`catch-arena docs isolation`)"
    )
