"""Settings that all tests share: hypothesis's examples, generous time limits, one compilation for all processes."""

import math
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from isolation_levels import NOT_TESTED

from catch_arena.cli import terminal
from catch_arena.tournament import players
from catch_arena.tournament.isolation import sandbox
from catch_arena.tournament.isolation.quotas import Quotas

LONG = os.environ.get("CATCH_ARENA_LONG") == "1"
"""Set by `make laws`: the nightly profile."""

# The seed stands in pyproject.toml (--hypothesis-seed), and no run remembers another: what fails once, fails again.
_COMMON = settings(
    database=None, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
settings.register_profile("test", _COMMON, max_examples=100)
settings.register_profile("nightly", _COMMON, max_examples=5000)
settings.load_profile("nightly" if LONG else "test")

# Commands that tests start run this checkout, whatever is installed.
os.environ["PYTHONPATH"] = str(Path(__file__).parents[1])

# A busy machine makes no agent late, no match void and no output longer, unless a test names the limit.
Quotas.__init__.__kwdefaults__.update(init_s=120.0, bank_s=120.0)
players._STALL_S = 60.0
sandbox._END_S = 10.0
terminal._LINE_EVERY_S = math.inf

# A shell starts what runs in its background with interrupts ignored; commands that tests start would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def catch_arena(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Any]:
    """`catch-arena WORDS`, in a folder of its own."""
    from command_line import run

    monkeypatch.chdir(tmp_path)
    return run


@pytest.fixture
def without_a_screen(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Open small windows without a display, do not wait between frames, and close the windows after the test."""
    from catch_arena.render.optional_imports import pygame

    class SteadyClock:
        def tick(self, frames_per_s: int = 0) -> int:
            return 1000 // frames_per_s if frames_per_s else 0

    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    monkeypatch.setattr(pygame.time, "Clock", SteadyClock)
    monkeypatch.setattr("catch_arena.cli.matches._SIZE", (320, 320))
    yield
    pygame.display.quit()


@pytest.fixture(autouse=True)
def _no_lines_of_progress(monkeypatch: pytest.MonkeyPatch) -> None:
    """A slow machine adds no lines to what a command prints here; tests of these lines choose their own pause."""
    if (module := sys.modules.get("catch_arena.cli.terminal")) is not None:
        monkeypatch.setattr(module, "_LINE_EVERY_S", math.inf)


@pytest.hookimpl(optionalhook=True, tryfirst=True)
def pytest_xdist_setupnodes() -> None:
    """Compile the rules once, in two processes, before each process of the tests would."""
    program = "from catch_arena import ArenaConfig, Engine\nfor n in (1, 2): Engine(ArenaConfig(), n, any_control={})"
    compilers = [subprocess.Popen([sys.executable, "-c", program.format(options)]) for options in (False, True)]
    for compiler in compilers:
        assert compiler.wait() == 0, "the rules cannot be compiled"


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """The steps that engine and oracle played alike, over all tests and processes; and what could not be tested."""
    steps = sum(
        number
        for report in terminalreporter.getreports("passed")
        for name, number in report.user_properties
        if name == "steps"
    )
    if steps:
        terminalreporter.write_line(f"engine and oracle agree in every bit of {steps:,} steps")
    for line in NOT_TESTED:
        terminalreporter.write_line(line)
