"""The supervisor: the process that all isolated agents of one tournament process descend from, and that ends them.

It runs no agent's code. It starts a fork server for each entrant (fork_server.py), becomes the parent of every process
that loses its own, so that none escapes, and removes what agents wrote. It ends when its own parent does, however that
ends.

`sandbox.Sandbox` starts it, with a socket as its standard input.
"""

import os
import select
import shutil
import signal
import socket
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, NoReturn

from catch_arena.descendants import LINUX, family, kill_all
from catch_arena.tournament.isolation import fork_server
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.processes import adopt_orphans, die_with
from catch_arena.tournament.isolation.protocol import receive, send

_POLL_S: Final = 1.0
"""How often it looks whether its parent lives, where a copy of the socket keeps that from showing."""


def main() -> None:
    """Serve until the parent goes."""
    control, parent = socket.socket(fileno=0), os.getppid()
    adopt_orphans()
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # the dead need no burial
    signal.signal(signal.SIGTERM, _leave)
    folder = Path(tempfile.mkdtemp(prefix="catch-arena-agents-"))
    servers: set[int] = set()
    try:
        send(control, folder=str(folder))
        while (request := _next_request(control, parent)) is not None:
            message, files = request
            if "serve" in message:
                pid = _start_server(control, files[0], message["serve"], message["limits"])
                servers.add(pid)
                send(control, pid=pid)
            elif "end" in message:
                send(control, done=_end(servers, message["end"]))
            else:
                done = _sweep(servers)
                _empty(folder)
                send(control, done=done)
    except (BrokenPipeError, ConnectionResetError):
        pass
    finally:
        for pid in set(servers):
            _end(servers, pid)
        kill_all(lambda: family(os.getpid()))
        _empty(folder)
        folder.rmdir()


def _leave(number: int, _: object) -> NoReturn:
    """End in order, and not a second time."""
    signal.signal(number, signal.SIG_IGN)
    raise SystemExit


def _next_request(control: socket.socket, parent: int) -> tuple[dict[str, Any], list[int]] | None:
    while not select.select([control], [], [], _POLL_S)[0]:
        if os.getppid() != parent:
            return None
    return receive(control)


def _start_server(control: socket.socket, channel: int, spec: str, limits: dict[str, Any]) -> int:
    supervisor = os.getpid()
    pid = os.fork()
    if pid:
        os.close(channel)
        return pid
    try:
        die_with(supervisor)
        for usual in (signal.SIGCHLD, signal.SIGTERM):
            signal.signal(usual, signal.SIG_DFL)
        os.setsid()
        control.detach()  # descriptor 0, which is replaced
        null = os.open(os.devnull, os.O_RDWR)
        for standard in (0, 1, 2):
            os.dup2(null, standard)
        os.close(null)
        fork_server.serve(socket.socket(fileno=channel), spec, AgentLimits(**limits))
    finally:
        os._exit(0)


def _end(servers: set[int], pid: int) -> bool:
    """End a fork server and all that descends from it."""
    servers.discard(pid)
    if LINUX:
        return kill_all(lambda: family(os.getpid()) & {pid, *family(pid)})
    _end_group(pid)
    return True


def _sweep(servers: set[int]) -> bool:
    """End everything but the fork servers; where the system does not tell who descends from whom, these too."""
    if LINUX:
        return kill_all(lambda: family(os.getpid()) - servers)
    for pid in servers:
        _end_group(pid)
    servers.clear()
    return True


def _end_group(pid: int) -> None:
    with suppress(ProcessLookupError, PermissionError):  # macOS says the latter of the dead
        os.killpg(pid, signal.SIGKILL)


def _empty(folder: Path) -> None:
    """Remove all that is in a folder, whatever its permissions."""
    for place, names, _ in os.walk(folder):
        for name in names:
            if not (inner := Path(place, name)).is_symlink():
                inner.chmod(0o700)
    for entry in list(folder.iterdir()):
        shutil.rmtree(entry, ignore_errors=True)
