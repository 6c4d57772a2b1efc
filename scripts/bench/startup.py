"""Import and start-up, in fresh processes."""

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

ONE_ARENA = "import catch_arena as c; env = c.parallel_env(); env.reset(seed=1); env.step(dict.fromkeys(env.agents, 1))"
_BATCH = (
    "import catch_arena as c, numpy as np; arena = c.VectorArena('standard', 1024); arena.reset(1); "
    "arena.step(np.ones((1024, 4), dtype=np.int64))"
)
ONE_ARENA_WARM = "first step of one arena, warm"


def spent(code: str, environment: Mapping[str, str], folder: Path | None = None) -> dict[str, float]:
    """A Python process from beginning to end, with all that it starts: seconds on the wall, and CPU-seconds.

    Raises:
        subprocess.CalledProcessError: with what the process wrote to stderr.
    """
    wall, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", code], check=True, cwd=folder, env=environment, stderr=subprocess.PIPE)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return {
        "wall_s": time.perf_counter() - wall,
        "cpu_s": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
    }


def _median(code: str, environment: Mapping[str, str], times: int) -> dict[str, float]:
    turns = [spent(code, environment) for _ in range(times)]
    return {clock: statistics.median(turn[clock] for turn in turns) for clock in turns[0]}


def startup(*, quick: bool) -> dict[str, dict[str, float]]:
    """Seconds from the start of a process to its end; cold means that nothing compiled is kept from before."""
    times = 1 if quick else 5
    found = {
        "a bare interpreter": _median("pass", os.environ, times),
        "import of catch_arena": _median("import catch_arena", os.environ, times),
    }
    for what, code in (("a batch of 1024", _BATCH), ("one arena", ONE_ARENA)):
        with tempfile.TemporaryDirectory() as cache:
            environment = {**os.environ} if quick else {**os.environ, "NUMBA_CACHE_DIR": cache}
            first = _median(code, environment, 1)
            if not quick:  # where the user's own cache is used, the first may be cold or warm
                found[f"first step of {what}, cold"] = first
            found[f"first step of {what}, warm"] = _median(code, environment, times)
    return found
