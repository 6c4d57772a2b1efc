"""Attacks on other processes: the rival's, and those that keep the agents."""

import ctypes
import json
import os
import resource
import signal
import socket
import time
from contextlib import suppress
from pathlib import Path

from tournament.attacks.kit import ancestors, memory_of, secrets_in, siblings, tell


def writes_into_the_rivals_answers_through_proc(own):
    """The rival's next answer would be this one."""
    for pid in siblings():
        for file in Path(f"/proc/{pid}/fd").iterdir():
            if int(file.name) > 2:
                try:
                    there = os.open(file, os.O_WRONLY | os.O_NONBLOCK)
                except OSError:
                    continue
                os.write(there, json.dumps({"error": "I give up"}).encode() + b"\n")


def writes_into_the_rivals_log_through_proc(own):
    for pid in siblings():
        for number in (1, 2):
            try:
                there = os.open(f"/proc/{pid}/fd/{number}", os.O_WRONLY | os.O_NONBLOCK)
            except OSError:
                continue
            os.write(there, b"I am a cheat\n")


def takes_the_rivals_descriptors_by_pidfd(own):
    """Copies of them: what is written there is the rival's answer."""
    libc = ctypes.CDLL(None, use_errno=True)
    for pid in siblings():
        process = os.pidfd_open(pid)
        for number in range(3, 12):
            copy = libc.syscall(438, process, number, 0)  # pidfd_getfd
            if copy >= 0:
                os.set_blocking(copy, False)
                try:
                    os.write(copy, json.dumps({"error": "I give up"}).encode() + b"\n")
                except OSError:
                    continue


def searches_the_memory_of(pids):
    for pid in pids:
        with suppress(OSError), open(f"/proc/{pid}/mem", "rb", buffering=0) as memory:
            for begin, end in memory_of(pid):
                try:
                    memory.seek(begin)
                    found = secrets_in(memory.read(end - begin))
                except (OSError, OverflowError):
                    continue
                if found:
                    tell(found)
                    return


def reads_the_rivals_memory_through_proc(own):
    searches_the_memory_of(siblings())


def reads_the_rivals_memory_by_process_vm_readv(own):
    class Span(ctypes.Structure):
        _fields_ = [("begin", ctypes.c_void_p), ("size", ctypes.c_size_t)]

    libc = ctypes.CDLL(None, use_errno=True)
    libc.process_vm_readv.restype = ctypes.c_ssize_t
    for pid in siblings():
        for begin, end in memory_of(pid):
            content = ctypes.create_string_buffer(end - begin)
            here, there = Span(ctypes.addressof(content), end - begin), Span(begin, end - begin)
            read = libc.process_vm_readv(pid, ctypes.byref(here), 1, ctypes.byref(there), 1, 0)
            if read > 0 and (found := secrets_in(content)):
                tell(found)
                return


def takes_hold_of_the_rival_by_ptrace(own):
    libc = ctypes.CDLL(None, use_errno=True)
    for pid in siblings():
        if libc.ptrace(0x4206, pid, 0, 0) == 0:  # PTRACE_SEIZE, which does not stop it
            tell(f"hold of {pid}")


def reads_the_tournaments_memory(own):
    """Its environment is in there, and so are the seeds."""
    searches_the_memory_of(reversed(ancestors()[2:]))


def reads_the_tournaments_environment(own):
    for pid in [*ancestors(), *siblings()]:
        with suppress(OSError):
            tell(secrets_in(Path(f"/proc/{pid}/environ").read_bytes()))


def kills_the_rival(own):
    for pid in siblings():
        os.kill(pid, signal.SIGKILL)


def stops_the_rival(own):
    for pid in siblings():
        os.kill(pid, signal.SIGSTOP)


def takes_all_cpu_time_from_the_rival_by_prlimit(own):
    for pid in siblings():
        resource.prlimit(pid, resource.RLIMIT_CPU, (0, 0))


def changes_the_rivals_limits(own):
    for pid in siblings():
        soft, hard = resource.prlimit(pid, resource.RLIMIT_STACK)
        resource.prlimit(pid, resource.RLIMIT_STACK, (soft, hard))
        tell(f"{soft} of {pid}")


def makes_the_rival_slow_by_its_priority(own):
    for pid in siblings():
        os.setpriority(os.PRIO_PROCESS, pid, 19)
        tell(f"slow {pid}")


def takes_a_priority_above_all_others(own):
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    tell("real time")


def kills_its_fork_server(own):
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(60)


def stops_its_fork_server(own):
    if os.getppid() > 1:
        os.kill(os.getppid(), signal.SIGSTOP)
    os._exit(0)


def kills_the_supervisor(own):
    """The process above its fork server."""
    for pid in ancestors()[1:2]:
        os.kill(pid, signal.SIGKILL)
        time.sleep(60)


def stops_the_supervisor(own):
    for pid in ancestors()[1:2]:
        os.kill(pid, signal.SIGSTOP)


def kills_the_tournament(own):
    """The process that people have started, first."""
    for pid in reversed(ancestors()[2:]):
        os.kill(pid, signal.SIGKILL)


def stops_itself(own):
    os.kill(os.getpid(), signal.SIGSTOP)


def leaves_a_grandchild_that_lives_on_into_the_next_match(own):
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            os.execlp("sleep", "sleep", "98765.4321")
        os._exit(0)
    time.sleep(0.3)  # so that those of two matches are seen together


def gains_privileges_by_a_program_that_is_setuid(own):
    status = Path("/proc/self/status").read_text()
    if "NoNewPrivs:\t1" not in status:
        tell("new privileges")


def has_capabilities(own):
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("CapEff:") and int(line.split()[1], 16):
            tell(line)


def makes_a_user_namespace_of_its_own(own):
    """In it, it would be root, and have far more of the kernel to attack."""
    if os.fork() == 0:  # what comes next is tried outside
        if ctypes.CDLL(None).unshare(0x10000000) == 0:
            tell("root")
        os._exit(0)
    os.wait()


def lies_about_how_it_ended(own):
    """Its fork server tells, and runs its code."""
    os._exit(1)


def changes_what_its_fork_server_says():
    from catch_arena.tournament.isolation import protocol

    def send(channel, files=(), **message):
        socket.send_fds(channel, [b'{"ended":[[[' * 4096], [0] * 200)

    protocol.send = send


def passes_descriptors_to_the_tournament(own):
    """As long as somebody takes them: its own limit would be reached."""
    with socket.socket(fileno=os.dup(4)) as answers:
        for _ in range(200):
            socket.send_fds(answers, [b" "], [0] * 250)
