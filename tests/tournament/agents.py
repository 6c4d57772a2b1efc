"""Agents that tests write to files, because real processes play them."""

from pathlib import Path

_DIES_ONCE = """
import os, signal
from pathlib import Path


class Agent:
    def reset(self, seed): pass

    def act(self, view):
        died = Path(__file__).with_name("died")
        if not died.exists():
            died.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return 1
"""


def dies_once(folder: Path) -> str:
    """An agent that kills its process in its first move of all; after that it goes for the nearest target."""
    path = folder / "dies_once.py"
    path.write_text(_DIES_ONCE)
    return str(path)
