"""Real nodes and commands of ours on one ROS 2 bus, as processes with the environment that `make ros` made."""

import os
import re
import signal
import subprocess
import threading
import time
from contextlib import ExitStack
from pathlib import Path

import pytest
from ros.processes import own_domain

ROOT = Path(__file__).parents[2]
LONGEST_S = 240
"""No line takes longer, on any machine: a wait that ends by it is a failed test."""


class Process:
    """A process whose lines can be waited for."""

    def __init__(self, command, environment, folder):
        self.lines, self._news = [], threading.Condition()
        self._process = subprocess.Popen(
            command, env=environment, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self._process.stdout:
            with self._news:
                self.lines.append(line.rstrip("\n"))
                self._news.notify_all()
        with self._news:
            self.lines.append(None)
            self._news.notify_all()

    def wait_for(self, pattern, times=1):
        """The last match, once so many lines match; fails at the process's end, with all that it printed."""
        end = time.monotonic() + LONGEST_S
        with self._news:
            while True:
                found = [match for line in self.lines if line is not None and (match := re.search(pattern, line))]
                if len(found) >= times:
                    return found[times - 1]
                ended = None in self.lines
                if ended or not self._news.wait(max(0.0, end - time.monotonic())):
                    pytest.fail(f"no {pattern!r} {'before it ended' if ended else 'in time'}:\n{self.text}")

    @property
    def text(self):
        return "\n".join(line for line in self.lines if line is not None)

    def end(self, sent=signal.SIGINT):
        """Send a signal, and return the exit code and all that was printed."""
        if self._process.poll() is None:
            self._process.send_signal(sent)
        return self.finish()

    def finish(self):
        code = self._process.wait(LONGEST_S)
        self._reader.join()
        return code, self.text

    def kill(self):
        self._process.kill()
        self.finish()
        self._process.stdout.close()


class Bus:
    """A domain of its own, with the packages that a student has."""

    def __init__(self, stack, folder, environment, domain, packages):
        prefixes = [*(environment / "packages" / one for one in ("turtlesim", *packages)), environment]
        libraries = [str(one / "lib" / f"python{environment.name}" / "site-packages") for one in prefixes]
        usual = {key: value for key, value in os.environ.items() if not key.startswith(("ROS_", "RMW_", "AMENT_"))}
        self._stack, self._folder, self.python = stack, folder, str(environment / "bin" / "python")
        self._environment = usual | {
            "AMENT_PREFIX_PATH": os.pathsep.join(map(str, prefixes)),
            "LD_LIBRARY_PATH": os.pathsep.join(str(one / "lib") for one in prefixes),
            "PYTHONPATH": os.pathsep.join((str(ROOT), *libraries)),
            "PYTHONUNBUFFERED": "1",
            "COLUMNS": "400",
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_DOMAIN_ID": str(domain),
            "ROS_LOG_DIR": str(folder / "log"),
        }

    def command(self, *words):
        """`catch-arena ...`."""
        return self._start("-m", "catch_arena", *words)

    def serve(self, *words, waits=True):
        """`catch-arena ros serve ...`, once it waits for nodes."""
        served = self.command("ros", "serve", "--seed", "1", "--set", "time_limit_s=3600", *words)
        if waits:
            served.wait_for("^waiting for")
        return served

    def node(self, name, *words):
        """A node of nodes/, with its arguments."""
        return self._start(str(self.path_of(name)), *words)

    def path_of(self, name):
        """The file of a node of nodes/."""
        return ROOT / "tests" / "ros_nodes" / "nodes" / f"{name}.py"

    def _start(self, *words):
        process = Process([self.python, *words], self._environment, self._folder)
        self._stack.callback(process.kill)
        return process


@pytest.fixture
def bus_with(tmp_path):
    """Make a bus on which these interface packages are sourced."""
    if "ROS_NODES" not in os.environ:
        pytest.skip("`make ros` makes the environment that these tests need")
    with ExitStack() as stack:
        domain = 101 - stack.enter_context(own_domain())  # from the top: tests/ros, on another host too, begins with 1
        folder = tmp_path
        yield lambda *packages: Bus(stack, folder, Path(os.environ["ROS_NODES"]), domain, packages)
