"""Import and start-up, in fresh processes."""

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping

_ONE_ARENA = (
    "import catch_arena as c; env = c.parallel_env(); env.reset(seed=1); env.step(dict.fromkeys(env.agents, 1))"
)
_BATCH = (
    "import catch_arena as c, numpy as np; arena = c.VectorArena('standard', 1024); arena.reset(1); "
    "arena.step(np.ones((1024, 4), dtype=np.int64))"
)


def _median(code: str, environment: Mapping[str, str], times: int) -> dict[str, float]:
    """A Python process from beginning to end: seconds on the wall, and CPU-seconds."""
    walls, cpus = [], []
    for _ in range(times):
        wall, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", code], check=True, env=environment, stderr=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        walls.append(time.perf_counter() - wall)
        cpus.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return {"wall_s": statistics.median(walls), "cpu_s": statistics.median(cpus)}


def startup(*, quick: bool) -> dict[str, dict[str, float]]:
    """Seconds from the start of a process to its end; cold means that nothing compiled is kept from before."""
    times = 1 if quick else 5
    found = {
        "a bare interpreter": _median("pass", os.environ, times),
        "import of catch_arena": _median("import catch_arena", os.environ, times),
    }
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ} if quick else {**os.environ, "NUMBA_CACHE_DIR": cache}
        if not quick:
            found["first step of a batch of 1024, cold"] = _median(_BATCH, environment, 1)
        found["first step of a batch of 1024, warm"] = _median(_BATCH, environment, times)
        found["first step of one arena, warm"] = _median(_ONE_ARENA, environment, times)
    return found
