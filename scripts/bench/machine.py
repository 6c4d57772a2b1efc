"""The machine of a measurement, for pages of results."""

import importlib.metadata
import os
import platform
from pathlib import Path

from catch_arena.core.vectors import PLAYED


def machine() -> str:
    """Return the processor, the number of arenas in one of its registers, and the versions that affect the results."""
    known = Path("/proc/cpuinfo")
    lines = known.read_text().splitlines() if known.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    model = names[0] if names else platform.processor() or platform.machine()
    installed = {found.name: found.version for found in importlib.metadata.distributions()}
    packages = ("numpy", "numba", "pettingzoo", "mpe2", "torch", "vmas", "jax", "jaxmarl")
    versions = ", ".join(f"{name} {installed[name]}" for name in packages if name in installed)
    system = f"{os.cpu_count()} cores, {len(PLAYED)} arenas in a register, {platform.system()}"
    return f"{model}, {system}; Python {platform.python_version()}, {versions}"
