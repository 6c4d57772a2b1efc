"""Grading of students' ROS 2 nodes: each is started by the spec's launch command, graded, and ended.

The nodes are not isolated: they run as the teacher, one after the other.
"""

import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile
from typing import Final

from catch_arena import interrupts
from catch_arena.classroom.grading import Graded
from catch_arena.classroom.submissions import Submission
from catch_arena.errors import BusError, ConfigError
from catch_arena.ros.node_tests.cases import grade_node
from catch_arena.ros.node_tests.node_under_test import NodeUnderTest
from catch_arena.text import last_lines, one_line, printable_lines
from catch_arena.tournament.execution.executors import ProcessExecutor, Worker
from catch_arena.tournament.grading import TestGrade, unplayed_grade
from catch_arena.tournament.grading_spec import GradingSpec

Join = Callable[[], AbstractContextManager[NodeUnderTest]]
_END_S: Final = 3.0
"""Time for a node to end after Ctrl-C [s]."""
_LOG_BYTES: Final = 1 << 16
"""Part of a node's output that is kept, from its end [bytes]."""
_LARGEST_FILE: Final = 1 << 17
"""Largest size of a file that a node writes, such as its output [512 bytes]."""


def grade_node_of(worker: Worker, spec: GradingSpec, join: Join, submission: Submission) -> Graded:
    """Grade the node in a student's folder; a test without an answer gives no points.

    `worker` begins the process in which `join` joins the bus.
    """
    grades: list[TestGrade] = []
    fault, printed = "must be a folder, in which the spec's launch command starts the node", ""
    if submission.path.is_dir():
        # a process of its own for each: what a process has published is seen by its next nodes
        with _started(spec.launch, submission.path) as (process, log), ProcessExecutor(worker, 1) as fresh:
            grades, fault = fresh.result(fresh.run(_ask, spec, join))
            if process.poll() is not None:
                fault += f"; its launch command ended with code {process.returncode}"
            printed = os.pread(log, _LOG_BYTES, max(0, os.fstat(log).st_size - _LOG_BYTES)).decode(errors="replace")
    missing = (unplayed_grade(test, one_line(fault), hinted=False) for test in spec.tests[len(grades) :])
    return Graded(
        name=submission.name,
        digest=submission.digest(),
        grades=(*grades, *missing),
        log=last_lines(printable_lines(printed)),
    )


def _ask(spec: GradingSpec, join: Join) -> tuple[list[TestGrade], str]:
    """Return the grades of the node on the bus, and the reason for which there are no more."""
    grades: list[TestGrade] = []
    with join() as node:
        try:
            grades.extend(grade_node(spec, node))
        except (BusError, ConfigError) as error:
            return grades, str(error)
    return grades, ""


@contextmanager
def _started(command: str, folder: Path) -> Iterator[tuple[subprocess.Popen[bytes], int]]:
    """Start a shell command in a folder, and yield its process and the descriptor of the file that has its output; at
    the end, end it and all that it started.
    """
    with TemporaryFile() as log:
        process = subprocess.Popen(  # noqa: S602 - the teacher's own line
            f"ulimit -f {_LARGEST_FILE}\n{command}",
            shell=True,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            yield process, log.fileno()
        finally:
            _end(process, signal.SIGINT)
            deadline = time.monotonic() + _END_S
            while (process.poll() is None or interrupts.descendants(process.pid)) and time.monotonic() < deadline:
                time.sleep(0.05)
            _end(process, signal.SIGKILL)
            process.wait()


def _end(process: subprocess.Popen[bytes], number: int) -> None:
    """Send a signal to the processes of a session, and to those that have left it."""
    for pid in interrupts.descendants(process.pid):
        with suppress(OSError):
            os.kill(pid, number)
    with suppress(OSError):
        os.killpg(process.pid, number)
