"""What a run with several processes says of itself: dots alone would leave one waiting, most of all in a log."""

import threading
import time

import pytest

EVERY_S = 15
"""[s] between two lines."""


class Progress:
    """A plugin for the process that hands out the tests: it loads the rules first, then tells how far all are.

    The lines come from a thread, since nothing else happens while every process is at a long test.
    """

    def __init__(self) -> None:
        self.started = time.monotonic()
        self.step = "loading the rules"
        self.total = self.ended = 0
        self.left: dict[str, int] = {}
        self.running: list[str] = []
        self.over = threading.Event()
        self.teller = threading.Thread(target=self._tell, daemon=True)

    @pytest.hookimpl(tryfirst=True)
    def pytest_xdist_setupnodes(self, config: pytest.Config) -> None:
        """Before the processes start: each of them would compile what is compiled here once."""
        from catch_arena.config import ArenaConfig
        from catch_arena.engine import Engine

        self.terminal = config.get_terminal_writer()
        self.terminal.line("loading the rules; the first time they are compiled, which can take a minute")
        self.teller.start()
        Engine(ArenaConfig())
        self.step = "collecting the tests"
        self.terminal.line("collecting the tests, in each process")

    def pytest_xdist_node_collection_finished(self, ids: list[str]) -> None:
        self.total = len(ids)

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.running.append(nodeid)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """A test's last report is of its teardown, or of the end of the process that it brought down."""
        if report.when not in {"setup", "call"}:
            self.running.remove(report.nodeid)
            self.ended += 1

    def pytest_testnodedown(self, node: object) -> None:
        """Each process has collected all tests and left out the same ones."""
        self.left = getattr(node, "workeroutput", {}).get("left", {})

    def pytest_sessionfinish(self) -> None:
        self.over.set()

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        for target, count in self.left.items():
            if count:
                terminalreporter.write_line(f"left to make {target}: {count} tests")

    def _tell(self) -> None:
        while not self.over.wait(EVERY_S):
            minutes, seconds = divmod(int(time.monotonic() - self.started), 60)
            far = f"{self.ended:,} of {self.total:,} tests" if self.total else self.step
            if self.terminal.width_of_current_line:
                self.terminal.line()
            self.terminal.line(f"{minutes}:{seconds:02}  {far}")
            for nodeid in self.running:
                self.terminal.line(f"        at {nodeid}")
