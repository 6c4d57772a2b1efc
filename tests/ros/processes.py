"""Processes that a test starts, and that end with it."""

import os
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

HERE = Path(__file__).parent


@contextmanager
def started(script, *arguments):
    """A script of this folder, or `catch-arena` where it is None."""
    command = ["-m", "catch_arena"] if script is None else [HERE / script]
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(str(HERE.parents[level]) for level in (0, 1)),
        "PYTHONUNBUFFERED": "1",
        "ROS_LOCALHOST_ONLY": "1",
    }
    with subprocess.Popen(
        [sys.executable, *command, *map(str, arguments)],
        env=environment,
        cwd=HERE.parents[1],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()
