"""PufferLib's environment `target`, driven from C, where its source package lies on this machine."""

import ctypes
import os
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

HEADER = Path("pufferlib", "ocean", "target", "target.h")
"""In the source package: the whole environment."""
_DRIVER = Path(__file__).with_name("puffer.c")
_FLAGS = ("-O3", "-march=native", "-fwrapv", "-shared", "-fPIC")
"""For this very processor, as our own code is compiled."""
_UNDRAWN = ("-fvisibility=hidden", "-ffunction-sections", "-Wl,--gc-sections")
"""Leave out the functions that draw, and with them raylib, of which only the header has to be there."""


class Driver:
    """The compiled driver.

    Raises:
        RuntimeError: with the compiler's first error.
        FileNotFoundError: where there is no compiler.
    """

    def __init__(self, source: Path) -> None:
        with tempfile.TemporaryDirectory() as folder:
            library = Path(folder, "puffer.so")
            headers = [source / HEADER.parent, *sorted(source.glob("raylib-*/include"))]
            command = [os.environ.get("CC", "cc"), *_FLAGS, *_UNDRAWN, *(f"-I{one}" for one in headers), _DRIVER]
            done = subprocess.run([*command, "-lm", "-o", library], check=False, capture_output=True, text=True)
            if done.returncode:
                errors = (line for line in done.stderr.splitlines() if "error" in line)
                raise RuntimeError(next(errors, done.stderr).replace(f"{source}{os.sep}", ""))
            self.library = ctypes.CDLL(str(library))
        self.library.make_batch.restype = ctypes.c_void_p
        self.library.play.argtypes = (ctypes.c_void_p, ctypes.c_int)

    def batch(self, envs: int, agents: int, goals: int, steps: int) -> Callable[[], None]:
        """That many environments, and a call that plays that many steps of each."""
        batch = self.library.make_batch(envs, agents, goals)
        if not batch:
            raise MemoryError
        return lambda: self.library.play(batch, steps)
