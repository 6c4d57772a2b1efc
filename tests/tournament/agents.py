"""Agents that tests write to files, because real processes play them."""

from pathlib import Path
from textwrap import indent

_AGENT = """{before}
class Agent:
    step = 0

    def reset(self, seed):
{reset}

    def act(self, view):
        self.step += 1
{act}
"""

LEAVES_A_CHILD = """
if os.fork() == 0:
    os.setsid()
    if os.fork() == 0:
        os.execvp("sleep", ["sleep", "98765"])
    os._exit(0)
os.wait()
"""
"""In `reset`: a child that leaves the family, with a session of its own, and its parent gone."""


def source(act: str = "return 0", reset: str = "pass", before: str = "") -> str:
    """Return an agent's module; `act` and `reset` are the lines of these methods, `self.step` counts moves from 1."""
    return _AGENT.format(before=before, reset=indent(reset, " " * 8), act=indent(act, " " * 8))


def write_agent(path: Path, act: str = "return 0", reset: str = "pass", before: str = "") -> str:
    """Write such an agent to a file; return its path."""
    path.write_text(source(act, reset, before))
    return str(path)


def dies_once(folder: Path) -> str:
    """Write an agent that kills its process in its first move of all; then it goes for the nearest target."""
    lines = (
        "died = Path(__file__).with_name('died')",
        "if not died.exists():",
        "    died.touch()",
        "    os.kill(os.getpid(), signal.SIGKILL)",
        "return 1",
    )
    return write_agent(
        folder / "dies_once.py", "\n".join(lines), before="import os, signal\nfrom pathlib import Path\n"
    )
