"""How many examples hypothesis tries, and how much the engine was held against the oracle."""

import os
import signal

import pytest
from hypothesis import HealthCheck, settings

LONG = os.environ.get("CATCH_ARENA_LONG") == "1"
"""Set by `make laws`: the nightly profile."""

# The seed stands in pyproject.toml (--hypothesis-seed), and no run remembers another: what fails once, fails again.
_COMMON = settings(
    database=None, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
settings.register_profile("test", _COMMON, max_examples=200)
settings.register_profile("nightly", _COMMON, max_examples=5000)
settings.load_profile("nightly" if LONG else "test")

# A shell starts what runs in its background with interrupts ignored; commands that tests start would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """The steps that engine and oracle played alike, over all tests and processes."""
    steps = sum(
        number
        for report in terminalreporter.getreports("passed")
        for name, number in report.user_properties
        if name == "steps"
    )
    if steps:
        terminalreporter.write_line(f"engine and oracle agree in every bit of {steps:,} steps")
