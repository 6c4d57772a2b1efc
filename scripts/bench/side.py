"""Processes that measure: one for each version of the package, and one for the peers."""

import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ProcessPoolExecutor
from pathlib import Path
from typing import Any

from subject import Row, Subject
from versions import ROOT, UnmeasurableError

_PROCESSORS = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()
"""Processors of this machine on Linux; empty elsewhere."""
_ENVIRONMENT = {
    **dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"),
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
    "JAX_PLATFORMS": "cpu",
}
_subjects: dict[str, Subject] = {}
"""Subjects of a measuring process, by the name of the row."""


class Side:
    """Process that measures one version of the package, or the peers, and its results.

    Args:
        title: name in error messages.
        root: folder that holds the version's package; None for the peers.
        cache: folder for compiled code, which is kept from row to row.
        rows: rows to measure, by name.
    """

    def __init__(self, title: str, root: Path | None, cache: Path, rows: Mapping[str, Row]) -> None:
        self.title, self.root, self.rows = title, root, rows
        self.figures: dict[str, dict[str, Any]] = {}
        """Agents, envs and floats of each row; "cpu" and "wall" have the times of a step [s], one for each round."""
        self._process = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), _begin, (root, cache))

    def make(self, name: str, seconds: float) -> "Future[dict[str, int]]":
        """Begin to make a row's subject and to play an unmeasured turn; the result has the sizes of the subject."""
        return self._start(_make, name, self.rows[name].make, seconds, self.root)

    def play(self, name: str, seconds: float) -> None:
        """Play one turn of a row, and keep its times."""
        for clock, time_s in zip(("cpu", "wall"), self._start(_turn, name, seconds).result(), strict=True):
            self.figures[name][clock].append(time_s)

    def end(self) -> None:
        """End the process, also while it measures."""
        for process in self._process._processes.values():  # noqa: SLF001 - Python 3.14 has kill_workers()
            process.kill()

    def _start(self, work: Callable[..., Any], *arguments: object) -> "Future[Any]":
        return self._process.submit(_run, self.title, work, *arguments)


def _begin(root: Path | None, cache: Path) -> None:
    """Prepare a measuring process; the rows import the package later, from the version's folder."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the main process ends this one after Ctrl-C
    os.dup2(2, 1)  # prints of a peer must not stand among the tables
    os.environ |= {**_ENVIRONMENT, "PYTHONPATH": str(root or ""), "NUMBA_CACHE_DIR": str(cache)}
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # users keep bytecode too
    os.chdir(root or ROOT)
    if root:
        sys.path.insert(0, str(root))


def _run(title: str, work: Callable[..., Any], *arguments: object) -> Any:
    """Return the result of work in a measuring process.

    Raises:
        UnmeasurableError: for any error, since the main process may not know those of peers and older versions.
    """
    try:
        return work(*arguments)
    except Exception as error:  # noqa: BLE001
        message = " ".join(f"{type(error).__name__}: {error}".split())
        raise UnmeasurableError(f"{title} cannot be measured: {message}") from None


def _make(name: str, make: Callable[[], Subject], seconds: float, root: Path | None) -> dict[str, int]:
    """Make a row's subject and play an unmeasured turn of it; return its sizes.

    Raises:
        ImportError: Catch Arena was imported from another folder.
    """
    _subjects[name] = made = make()
    made.turn(seconds)
    for module in [one for key, one in sys.modules.items() if key.partition(".")[0] == "catch_arena"]:
        file = getattr(module, "__file__", None)
        if root and file and not Path(file).is_relative_to(root):
            raise ImportError(f"{module.__name__} must come from {root}, not from {file}")
    return {"agents": made.agents, "envs": made.envs, "floats": made.floats}


def _turn(name: str, seconds: float) -> tuple[float, float]:
    """Play one turn, and return its times of a step [s]: CPU time and wall time.

    A single-threaded subject gets one fixed processor, since those of a shared machine differ in speed for minutes.
    """
    subject = _subjects[name]
    if _PROCESSORS:
        os.sched_setaffinity(0, _PROCESSORS if subject.threads > 1 else {max(_PROCESSORS)})
    times = subject.turn(seconds)
    if _PROCESSORS:
        os.sched_setaffinity(0, _PROCESSORS)
    return times
