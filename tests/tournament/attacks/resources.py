"""Attacks on the machine: processes, memory, output; each ends by itself before it does harm."""

import _thread
import ctypes
import fcntl
import mmap
import os
import resource
import signal
import socket
import struct
import threading
import time
from contextlib import suppress

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
    files = []
    for number in range(24):
        files.append(open(os.memfd_create(f"{number}"), "wb"))
        files[-1].write(bytes(12 << 20))
    time.sleep(1)
    tell("288 MiB")


def takes_memory_by_system_v_segments(own):
    """Nor these: 10 times 30 MiB, which no process has mapped any more."""
    takes_system_v_segments(ctypes.CDLL(None).shmget)


def takes_memory_by_system_v_segments_and_calls_of_32_bits(own):
    """The same, through the door for old programs."""
    if os.uname().machine != "x86_64":
        return
    code = bytes.fromhex("53 56 b8 75000000 bb 17000000 31c9 ba 0000e001 be 80030000 cd80 5e 5b c3")  # ipc(SHMGET, ...)
    with mmap.mmap(-1, 4096, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, mmap.PROT_READ | 2 | mmap.PROT_EXEC) as program:
        program.write(code)
        place = ctypes.c_char.from_buffer(program)
        call = ctypes.CFUNCTYPE(ctypes.c_int)(ctypes.addressof(place))
        takes_system_v_segments(lambda *_: call())
        del place


def takes_system_v_segments(get):
    libc = ctypes.CDLL(None)
    libc.shmat.restype = ctypes.c_void_p
    numbers = []
    try:
        for _ in range(10):
            number = get(0, 30 << 20, 0o1600)
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


def takes_memory_by_system_v_messages(own):
    """Each queue holds 16 KiB of them: 9,600 queues."""
    libc = ctypes.CDLL(None)
    message = struct.pack("l8000s", 1, b"x")
    queues, taken = [], 0
    try:
        while len(queues) < 9600 and (queue := libc.msgget(0, 0o1600)) >= 0:
            queues.append(queue)
            while libc.msgsnd(queue, message, 8000, 0o4000) == 0:
                taken += 8000
        time.sleep(1)
        if taken > 140 << 20:
            tell(f"{taken >> 20} MiB")
    finally:
        for queue in queues:
            libc.msgctl(queue, 0, None)


def takes_memory_by_forgetting_what_it_shares(own):
    """Memory for forks stays, though no process has it at hand any more: 10 times 30 MiB, in 10 processes."""
    told, tells = os.pipe()
    children = []
    for _ in range(10):
        if not (child := os.fork()):
            shared = mmap.mmap(-1, 30 << 20)
            shared.write(b"x" * len(shared))
            shared.madvise(mmap.MADV_DONTNEED)
            os.write(tells, b"x")
            time.sleep(2)
            os._exit(shared[-1:] != b"x")
        children.append(child)
        os.read(told, 1)  # one after the other: what each has written it has forgotten
    if not any(os.waitpid(child, 0)[1] for child in children):
        tell("300 MiB")


def takes_memory_by_pages_that_lie_in_pipes(own):
    """A pipe holds a page of 2 MiB for each byte of it that was passed: 8 times 16 pages."""
    libc = ctypes.CDLL(None)
    libc.mmap.restype = ctypes.c_void_p
    page, pages, private = 2 << 20, 16, 0x22
    pipes = []
    for _ in range(8):
        pipes.append([open(end, "wb") for end in os.pipe()])
        place = libc.mmap(None, ctypes.c_size_t((pages + 1) * page), 3, private, -1, 0)
        begin = -(-place // page) * page
        libc.madvise(ctypes.c_void_p(begin), ctypes.c_size_t(pages * page), mmap.MADV_HUGEPAGE)
        ctypes.memset(begin, 1, pages * page)
        into = pipes[-1][1].fileno()
        passed = [libc.vmsplice(into, struct.pack("PN", begin + number * page, 1), 1, 0) for number in range(pages)]
        libc.munmap(ctypes.c_void_p(place), ctypes.c_size_t((pages + 1) * page))
        if sum(passed) < pages:
            return
    time.sleep(1)
    tell("256 MiB")


def takes_memory_by_rings_of_the_kernel(own):
    """Of the largest io_uring, which takes 3 MiB: 50 of them."""
    libc = ctypes.CDLL(None)
    rings = []
    while len(rings) < 50 and (ring := libc.syscall(425, 32_768, ctypes.create_string_buffer(120))) >= 0:
        rings.append(open(ring, "wb"))
    time.sleep(1)
    if len(rings) == 50:
        tell("150 MiB")


def takes_memory_by_pipes_that_nobody_reads(own):
    """The kernel gives all processes of a user 64 MiB of them, and root more: 6 times 25 of 1 MiB."""
    told, tells = os.pipe()
    children = []
    for _ in range(6):
        if not (child := os.fork()):
            os.write(tells, struct.pack("N", sum(fill_a_pipe(1 << 20) for _ in range(25))))
            time.sleep(30)
            os._exit(0)
        children.append(child)
    taken = sum(struct.unpack("N", os.read(told, 8))[0] for _ in children)
    for child in children:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    if taken > 100 << 20:
        tell(f"{taken >> 20} MiB")


def fill_a_pipe(size):
    """How much it took; it stays open."""
    _, into = os.pipe()
    with suppress(PermissionError):
        fcntl.fcntl(into, 1031, size)
    os.set_blocking(into, False)
    return os.write(into, bytes(size))


def takes_memory_by_connections_that_nobody_reads(own):
    """They grow as they are used."""
    taken, ends = 0, []
    with socket.create_server(("127.0.0.1", 0)) as server:
        for _ in range(24):
            ends += [socket.create_connection(server.getsockname()), server.accept()[0]]
            taken += fill(ends[-1]) + fill(ends[-2])
    time.sleep(1)
    if taken > 130 << 20:
        tell(f"{taken >> 20} MiB")


def fill(connection):
    """Write to it until it takes no more for a moment: how many bytes."""
    connection.settimeout(0.1)
    taken, content = 0, bytes(1 << 20)
    with suppress(TimeoutError):
        while True:
            taken += connection.send(content)
    return taken


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
