"""Processes that measure: one for each version of the package, and one for the peers."""

import multiprocessing
import os
import signal
import sys
from multiprocessing.connection import Connection
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


class Side:
    """Process that measures one version of the package, or the peers, and its results.

    Args:
        title: name in error messages.
        root: folder that holds the version's package; None for the peers.
        cache: folder for compiled code, which is kept from row to row.
        pufferlib: PufferLib's unpacked source package, if there is one.
    """

    def __init__(self, title: str, root: Path | None, cache: Path, pufferlib: Path | None) -> None:
        self.title = title
        self.rows: dict[str, dict[str, Any]] = {}
        """Rows by name: agents, envs and floats; "cpu" and "wall" have the times of a step [s], one for each round."""
        context = multiprocessing.get_context("spawn")
        self._pipe, end = context.Pipe()
        self._process = context.Process(target=_serve, args=(end, root, cache, pufferlib), daemon=True)
        self._process.start()
        end.close()

    def send(self, verb: str, name: str, seconds: float) -> None:
        """Send a request, "make" or "turn", without waiting for the answer."""
        self._pipe.send((verb, name, seconds))

    def answer(self) -> Any:
        """Return the answer to the last request.

        Raises:
            UnmeasurableError: a row cannot be measured.
        """
        try:
            found = self._pipe.recv()
        except EOFError:
            found = RuntimeError("its process has ended")
        if isinstance(found, Exception):
            raise UnmeasurableError(f"{self.title} cannot be measured: {' '.join(str(found).split())}")
        return found

    def play(self, name: str, seconds: float) -> None:
        """Play one turn of a row, and keep its times."""
        self.send("turn", name, seconds)
        for clock, time_s in zip(("cpu", "wall"), self.answer(), strict=True):
            self.rows[name][clock].append(time_s)

    def end(self) -> None:
        """End the process."""
        self._process.kill()


def _serve(pipe: Connection, root: Path | None, cache: Path, pufferlib: Path | None) -> None:
    """Answer requests until the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the main process ends this one after Ctrl-C
    os.dup2(2, 1)  # prints of a peer must not stand among the tables
    os.environ |= {**_ENVIRONMENT, "PYTHONPATH": str(root or ""), "NUMBA_CACHE_DIR": str(cache)}
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # users keep bytecode too
    os.chdir(root or ROOT)
    if root:
        sys.path.insert(0, str(root))
    made: dict[str, Subject] = {}
    while True:
        verb, name, seconds = pipe.recv()
        try:
            if verb == "make":
                made[name] = _rows(root, pufferlib)[name].make()
                pipe.send(_warm_up(made[name], seconds, root))
            else:
                pipe.send(_turn(made[name], seconds))
        except Exception as error:  # noqa: BLE001 - peers and older versions may raise any error
            pipe.send(RuntimeError(f"{type(error).__name__}: {error}"))


def _rows(root: Path | None, pufferlib: Path | None) -> dict[str, Row]:
    """Return the rows of this process; they are imported here, after the version's folder is on the path."""
    if root:
        import ours

        return ours.rows()
    import peers

    return peers.rows(pufferlib)


def _warm_up(subject: Subject, seconds: float, root: Path | None) -> dict[str, int]:
    """Play an unmeasured turn of a new subject, and return its sizes.

    Raises:
        ImportError: Catch Arena was imported from another folder.
    """
    subject.turn(seconds)
    for module in [one for key, one in sys.modules.items() if key.partition(".")[0] == "catch_arena"]:
        file = getattr(module, "__file__", None)
        if root and file and not Path(file).is_relative_to(root):
            raise ImportError(f"{module.__name__} must come from {root}, not from {file}")
    return {"agents": subject.agents, "envs": subject.envs, "floats": subject.floats}


def _turn(subject: Subject, seconds: float) -> tuple[float, float]:
    """Play one turn, and return its times of a step [s]: CPU time and wall time.

    A single-threaded subject gets one fixed processor, since those of a shared machine differ in speed for minutes.
    """
    if _PROCESSORS:
        os.sched_setaffinity(0, _PROCESSORS if subject.threads > 1 else {max(_PROCESSORS)})
    times = subject.turn(seconds)
    if _PROCESSORS:
        os.sched_setaffinity(0, _PROCESSORS)
    return times
