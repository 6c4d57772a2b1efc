"""The rules, compiled in a process beside pip: that takes as long as to install the rest."""

import subprocess
import time
from threading import Thread

from environment import Environment
from words import TOLD_EVERY_S, last_line, say

NEEDS = ("numba", "numpy", "platformdirs")
"""What is installed first for it."""
_COMMAND = "from catch_arena import Engine, scenario; Engine(scenario('standard'))"


class Compilation:
    """One that has begun."""

    def __init__(self, environment: Environment) -> None:
        self._began = time.monotonic()
        self._process = subprocess.Popen(
            [environment.python, "-c", _COMMAND],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
        )
        self._said: list[str] = []
        Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        self._said += self._process.stderr or ()

    def finish(self) -> None:
        """Wait for its end, and say so; a failure is told, and stops nothing: the first match compiles again."""
        while True:
            try:
                self._process.wait(timeout=TOLD_EVERY_S)
            except subprocess.TimeoutExpired:
                say(f"  {time.monotonic() - self._began:3.0f} s  compiling the rules for this machine, once")
            else:
                break
        if self._process.returncode:
            say(f"the rules were not compiled: {last_line(''.join(self._said))}")

    def stop(self) -> None:
        """End it, wherever it is."""
        self._process.kill()
        self._process.wait()
