"""Attacks on the machine: processes, memory, output; each ends by itself before it does harm."""

import _thread
import ctypes
import os
import resource
import signal
import threading
import time

from tournament.attacks.kit import tell

_PROCESSES = 300
_THREADS = 10_000


def forks_300_processes(own):
    """A bomb that ends by itself: real ones do not."""
    children = []
    try:
        for _ in range(_PROCESSES):
            if not (child := os.fork()):
                time.sleep(30)
                os._exit(0)
            children.append(child)
        tell(f"{len(children)} processes")
        time.sleep(0.5)
        tell(f"{sum(os.waitpid(child, os.WNOHANG) == (0, 0) for child in children)} processes live on")
    finally:
        for child in children:
            os.kill(child, signal.SIGKILL)


def starts_10_000_threads(own):
    """All wait, without a word to Python."""
    _thread.stack_size(64 << 10)
    closed = _thread.allocate_lock()
    closed.acquire()
    for _ in range(_THREADS):
        _thread.start_new_thread(closed.acquire, ())
    tell(f"{_thread._count()} threads")


def takes_memory_in_many_processes(own):
    """Each takes less than the limit: 12 times 50 MiB, where one may have 64."""
    told, tells = os.pipe()
    children = []
    for _ in range(12):
        if not (child := os.fork()):
            hoard = bytearray(b"x") * (50 << 20)
            os.write(tells, b"x")
            time.sleep(30)
            os._exit(len(hoard) and 0)
        children.append(child)
    os.close(tells)
    os.set_blocking(told, False)
    time.sleep(3)
    full = len(os.read(told, 100))
    alive = sum(os.waitpid(child, os.WNOHANG) == (0, 0) for child in children)
    if min(full, alive) == len(children):
        tell("600 MiB")
    for child in children:
        os.kill(child, signal.SIGKILL)


def takes_memory_by_files_in_memory(own):
    """No limit of a process counts them: 24 times 12 MiB, where one may have 64."""
    for number in range(24):
        os.write(os.memfd_create(f"{number}"), bytes(12 << 20))
    time.sleep(1)
    tell("288 MiB")


def takes_memory_by_system_v_segments(own):
    """Nor these: 10 times 30 MiB, which no process has mapped any more."""
    libc = ctypes.CDLL(None)
    libc.shmat.restype = ctypes.c_void_p
    numbers = []
    try:
        for _ in range(10):
            number = libc.shmget(0, 30 << 20, 0o1600)
            if number < 0:
                return
            numbers.append(number)
            place = libc.shmat(number, None, 0)
            ctypes.memset(place, 1, 30 << 20)
            libc.shmdt(ctypes.c_void_p(place))
        time.sleep(1)
        tell("300 MiB")
    finally:
        for number in numbers:
            libc.shmctl(number, 0, None)


def runs_away_by_forking_for_ever(own):
    """Each process ends when its child has begun: whoever looks for it comes too late. After 8 s the last one ends."""
    end = time.monotonic() + 8
    if os.fork() == 0:
        while time.monotonic() < end:
            if os.fork():
                os._exit(0)
        os._exit(0)


def raises_its_own_limits(own):
    for what in (resource.RLIMIT_DATA, resource.RLIMIT_NOFILE, resource.RLIMIT_FSIZE, resource.RLIMIT_CORE):
        _, hard = resource.getrlimit(what)
        resource.setrlimit(what, (hard + 4096, hard + 4096))
        tell(f"limit {what} raised")


def prints_for_ever_while_it_plays(own):
    """A line without an end, from a thread."""

    def shout():
        while True:
            os.write(1, b"x" * 65536)

    threading.Thread(target=shout, daemon=True).start()


def answers_without_a_newline_for_ever(own):
    while True:
        os.write(4, b"x")


def answers_10_mb(own):
    os.write(4, b'{"action":"' + b"x" * 10_000_000 + b'"}\n')
    time.sleep(60)


def answers_with_brackets_in_brackets(own):
    """As many as the line is long."""
    os.write(4, b'{"action":' + b"[" * 30_000 + b"]" * 30_000 + b"}\n")
    time.sleep(60)


class NoText(BaseException):
    """What an agent may raise."""


def raises_an_exception_that_is_no_text(own):
    raise NoText("\ud800 \0 \u202e")


def prints_what_a_terminal_obeys(own):
    print("\x1b]0;mine\x07", flush=True)
    raise NoText("\x1b[31mred")


def has_a_name_that_a_table_could_take_for_markup(own):
    """Its file's name is the attack."""
