"""A family that is frozen does nothing, however quickly it grows; whoever is killed meanwhile is missed at once."""

import os
import signal
import subprocess
import sys
import time
import warnings

import pytest

from catch_arena.descendants import family, is_stopped, session_of
from catch_arena.tournament.isolation.freezer import Freezer
from catch_arena.tournament.isolation.newcomers import no_newcomers_left

GROWS = """
import os, time
file = os.open("work", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
def work():
    end = time.monotonic() + 0.2
    while time.monotonic() < end:
        os.write(file, b"x")
        time.sleep(0.001)
    os._exit(0)
while True:
    if os.fork() == 0:
        if os.fork() == 0: work()
        work()
    time.sleep(0.01)
    try:
        while os.waitpid(-1, os.WNOHANG)[0]: pass
    except ChildProcessError: pass
"""


@pytest.fixture
def grows(tmp_path):
    with (
        no_newcomers_left(),
        subprocess.Popen([sys.executable, "-c", GROWS], cwd=tmp_path, start_new_session=True) as process,
    ):
        while not (tmp_path / "work").exists() or len(family(process.pid)) < 5:
            time.sleep(0.01)
        yield process
        process.kill()


@pytest.mark.nightly
def test_a_frozen_family_does_nothing_until_it_may_go_on(grows, tmp_path):
    """On a machine with far more to do than cores a write under way has been seen to end after the stop."""
    freezer, late = Freezer(grows.pid), 0
    for _ in range(20):
        assert freezer.freeze()
        done = (tmp_path / "work").stat().st_size
        time.sleep(0.05)
        late += (tmp_path / "work").stat().st_size != done
        assert freezer.lost() is None
        freezer.thaw()
        patience = time.monotonic() + 60
        while (tmp_path / "work").stat().st_size == done:
            assert time.monotonic() < patience
            time.sleep(0.01)
    if late:
        warnings.warn(f"{late} of 20 times something was written after the stop", stacklevel=1)
    assert late <= 1


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGCONT])
def test_one_that_is_killed_or_told_to_go_on_is_lost_from_that_moment(grows, number):
    freezer = Freezer(grows.pid)
    for chosen in (lambda: max(family(grows.pid)), lambda: grows.pid):
        assert freezer.freeze()
        pid = chosen()
        still = freezer.lost()
        os.kill(pid, number)
        assert (still, freezer.lost()) == (None, pid)
        if number == signal.SIGKILL:
            freezer = Freezer(grows.pid)


def test_orphans_in_sessions_of_their_own_are_killed_and_other_children_are_not():
    orphan = "import os, time\nif os.fork() == 0:\n    os.setsid()\n    time.sleep(600)\n"
    with subprocess.Popen(["sleep", "600"]) as ours:
        with no_newcomers_left():
            subprocess.run([sys.executable, "-c", orphan], check=True)
            patience = time.monotonic() + 60
            while {0, os.getsid(0)} >= set(map(session_of, newcomers := family(os.getpid()) - {ours.pid})):
                assert time.monotonic() < patience
        assert ours.poll() is None
        assert not newcomers & family(os.getpid())
        ours.kill()


def test_who_is_told_to_stand_still_is_known_to_be_stopped_at_once():
    """Also before it has had its turn on a busy machine, when its state does not say so yet."""
    with subprocess.Popen(["yes"], stdout=subprocess.DEVNULL) as process:
        try:
            for _ in range(100):
                assert not is_stopped(process.pid)
                process.send_signal(signal.SIGSTOP)
                assert is_stopped(process.pid)
                process.send_signal(signal.SIGCONT)
        finally:
            process.kill()
    assert not is_stopped(process.pid)
