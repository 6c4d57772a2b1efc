"""The end of processes that descend from this one."""

import signal
import subprocess
import sys

import pytest

from catch_arena import descendants
from catch_arena.descendants import LINUX, end, parent_of

LARGE = """
import signal, time
signal.signal(signal.SIGTERM, signal.SIG_IGN)
held = bytearray(b"x") * (1 << 28)
time.sleep(60)
"""
"""It takes a while to die: so much memory is given back first."""
STARTS_ANOTHER = f"""
import os, signal, subprocess, sys, time
def say(text):
    os.write(1, text.encode() + b"\\n")  # in a handler too, which may come in the middle of it
def start(*_):
    say(str(subprocess.Popen([sys.executable, "-S", "-c", {LARGE!r}]).pid))
signal.signal(signal.SIGTERM, start)
say("ready")
while True:
    time.sleep(60)
"""


@pytest.mark.skipif(not LINUX, reason="the system does not say who descends from whom")
def test_what_is_started_when_the_end_is_asked_for_has_ended_too(monkeypatch):
    """Its parent is dead before it, and then nobody says any more that it descends from there."""
    monkeypatch.setattr(descendants, "_GRACE_S", 5.0)  # time to start, on a busy machine too
    with subprocess.Popen([sys.executable, "-S", "-c", STARTS_ANOTHER], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "ready\n"
        end([process.pid])
        assert parent_of(int(process.stdout.readline())) is None
        assert process.wait() == -signal.SIGKILL
