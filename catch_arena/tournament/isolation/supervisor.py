"""The supervisor: the process that all isolated agents of one tournament process descend from, and that ends them.

It runs no agent's code. It starts a fork server for each entrant (servers.py), becomes the parent of every process that
loses its own, so that none escapes, ends agents that take too much, and removes what agents wrote. It ends when its own
parent does, however that ends.

`sandbox.Sandbox` starts it, with a socket as its standard input.
"""

import os
import select
import signal
import socket
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, NoReturn

from catch_arena.descendants import LINUX, family, kill_all
from catch_arena.tournament.isolation import group_watch
from catch_arena.tournament.isolation.control_groups import AgentGroup, ControlGroups
from catch_arena.tournament.isolation.folders import empty
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.processes import adopt_orphans, close_to_others
from catch_arena.tournament.isolation.protocol import receive, send
from catch_arena.tournament.isolation.servers import Server, fork_it, start_in_namespaces

_POLL_S: Final = 0.2
"""How often it looks at what agents take, and whether its parent lives, which a copy of the socket may hide."""

_Servers = dict[int, Server]
"""By their process."""


def main() -> None:
    """Serve until the parent goes."""
    control, parent = socket.socket(fileno=0), os.getppid()
    adopt_orphans()
    close_to_others()
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # the dead need no burial
    signal.signal(signal.SIGTERM, _leave)
    folder = Path(tempfile.mkdtemp(prefix="catch-arena-agents-"))
    groups = ControlGroups.here()
    servers: _Servers = {}
    try:
        send(control, folder=str(folder))
        while (request := _next_request(control, parent, servers)) is not None:
            message, files = request
            if "serve" in message:
                send(control, **_start(control, servers, groups, message, files))
            elif "end" in message:
                ended = servers.pop(message["end"], None)
                send(control, done=ended is None or ended.end())
            elif "excess" in message:
                send(control, excess=servers[message["excess"]].excess())
            else:
                done = _sweep(servers)
                _empty(folder)
                send(control, done=done)
    except (BrokenPipeError, ConnectionResetError):
        pass
    finally:
        for server in servers.values():
            server.end()
        kill_all(lambda: family(os.getpid()))
        _empty(folder)
        folder.rmdir()


def _leave(number: int, _: object) -> NoReturn:
    """End in order, and not a second time."""
    signal.signal(number, signal.SIG_IGN)
    raise SystemExit


def _next_request(control: socket.socket, parent: int, servers: _Servers) -> tuple[dict[str, Any], list[int]] | None:
    while not select.select([control], [], [], _POLL_S)[0]:
        if os.getppid() != parent:
            return None
        for server in servers.values():
            server.look()
        _end_strays(servers)
    return receive(control)


def _end_strays(servers: _Servers) -> None:
    """End those whose fork server has ended without them: whose they are, nobody knows any more."""
    for pid in group_watch.children(os.getpid()) - servers.keys():
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def _start(
    control: socket.socket,
    servers: _Servers,
    groups: ControlGroups | None,
    message: dict[str, Any],
    files: list[int],
) -> dict[str, Any]:
    """Start a fork server; what is answered.

    Args:
        control: this process's socket.
        servers: those that run.
        groups: where control groups are made, if they are.
        message: who is to be served, and how.
        files: its socket, and where bubblewrap says why it fails.
    """
    channel, errors = files
    limits = AgentLimits(**message["limits"])
    group: AgentGroup | None = None
    try:
        group = None if groups is None else groups.make(limits)
        if limits.level == "namespaces":
            server = start_in_namespaces(channel, errors, message["serve"], limits, group)
        else:
            server = fork_it(channel, limits, group, (control.fileno(), errors))
    except OSError as error:
        if group is not None:
            group.remove()
        return {"pid": None, "error": str(error)}
    finally:
        for file in files:
            os.close(file)
    servers[server.pid] = server
    return {"pid": server.pid}


def _sweep(servers: _Servers) -> bool:
    """End everything but the fork servers; where the system does not tell who descends from whom, these too."""
    if LINUX:
        spared = {pid for server in servers.values() for pid in server.pids}
        return kill_all(lambda: family(os.getpid()) - spared)
    for server in servers.values():
        server.end_group()
    servers.clear()
    return True


def _empty(folder: Path) -> None:
    with suppress(OSError):  # what root has made immutable, say: each match has a folder of its own
        empty(folder)
