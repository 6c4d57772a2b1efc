"""Namespaces by bubblewrap: the command line before an agent's program, and a check that it works on this machine.

In them an agent has no network, sees no other processes, and sees a read-only file system with the files that it needs.
It can write to two small folders in memory. It is not root there, cannot become root, and cannot make further
namespaces.
"""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Final

import catch_arena.agents
from catch_arena.errors import ConfigError
from catch_arena.tournament.agent_spec import TEMPORARY, command_of, file_of, folder_of
from catch_arena.tournament.isolation.quotas import Level

SHARED: Final = Path("/dev/shm")  # noqa: S108 - in a file system of its own, as TEMPORARY
_PROGRAM: Final = "bwrap"
_UNPRIVILEGED_ID: Final = "65534"
_PROBE_S: Final = 20.0
_OPTIONS: Final = (
    *("--unshare-user", "--unshare-pid", "--unshare-net", "--unshare-ipc", "--unshare-uts", "--unshare-cgroup-try"),
    *("--uid", _UNPRIVILEGED_ID, "--gid", _UNPRIVILEGED_ID, "--hostname", "arena"),
    *("--disable-userns", "--cap-drop", "ALL", "--new-session", "--die-with-parent"),
)
_SYSTEM: Final = ("/usr", "/bin", "/sbin", "/lib", "/lib32", "/lib64", "/libx32", "/nix/store", "/gnu/store")
_SETTINGS: Final = (
    *("alternatives", "fonts", "java*", "jvm*", "ld.so.cache", "ld.so.conf", "ld.so.conf.d", "localtime", "magic"),
    *("mime.types", "nsswitch.conf", "os-release", "pki/tls/certs", "pki/tls/openssl.cnf", "ssl/certs"),
    *("ssl/openssl.cnf", "terminfo", "timezone"),
)
"""Files in /etc that programs read, without the machine's users, keys and names."""
_ENVIRONMENT: Final = ("bin", "etc", "include", "lib", "lib64", "pyvenv.cfg", "share")
"""Files and folders of a virtual environment."""


def available_level(required: Level | None = None) -> Level:
    """Return the required level of isolation, or raise ConfigError; for None return the best level of this machine."""
    if required == "processes":
        return required
    why = namespaces_fault()
    if why is not None and required is not None:
        raise ConfigError(f"isolation namespaces cannot be held here: {why}")
    return "namespaces" if why is None else "processes"


def level_line(level: Level) -> str:
    """Return a line for users with the level of isolation, and a warning if it is only processes."""
    if level == "namespaces":
        return "isolation: namespaces"
    why = namespaces_fault() or "namespaces would; --limit isolation=processes chose this level"
    return f"isolation: processes, which does not stop a hostile agent: {why} (`catch-arena docs isolation`)"


def bubblewrap_command(visible: Iterable[Path], writable_bytes: int) -> list[str]:
    """Return the command line up to the program that bubblewrap starts.

    The program can read the files and folders in `visible`, at the same paths as outside, and write to the folders
    TEMPORARY and SHARED, up to a size for each.
    """
    size = ["--size", str(writable_bytes), "--tmpfs"]
    words = [shutil.which(_PROGRAM) or _PROGRAM, *_OPTIONS, "--proc", "/proc"]
    words += ["--ro-bind-try", "/proc/sys", "/proc/sys"]  # if root runs the command, they belong to the agent's user
    words += ["--dev", "/dev", *size, str(SHARED), "--remount-ro", "/dev", *size, str(TEMPORARY)]
    paths = set(visible)
    shown = {path for path in paths if paths.isdisjoint(path.parents)}
    closed = {path.parent for path in shown if TEMPORARY in path.parent.parents}
    for path in sorted(shown | closed):  # a folder comes before its contents
        words += ["--tmpfs", str(path)] if path in closed else ["--ro-bind-try", str(path), str(path)]
    words += [word for path in sorted(closed) for word in ("--remount-ro", str(path))]
    return [*words, "--remount-ro", "/", "--chdir", str(TEMPORARY), "--"]


def namespaces_fault() -> str | None:
    """Return the reason for which namespaces do not work on this machine, with a remedy; None if they work."""
    return _fault(shutil.which(_PROGRAM))


@cache
def _fault(program: str | None) -> str | None:
    if sys.platform != "linux":
        return f"only Linux has namespaces, and this is {sys.platform}"
    if program is None:
        return "bubblewrap is not installed: apt-get install bubblewrap, or your system's package of that name"
    true = shutil.which("true") or "/bin/true"
    try:
        subprocess.run(  # noqa: S603 - a program of the system
            [*bubblewrap_command([*map(Path, _SYSTEM), Path(true)], 1 << 20), true],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            check=True,
            timeout=_PROBE_S,
        )
    except subprocess.TimeoutExpired:
        return f"{program} does not end"
    except OSError as error:
        return f"{program} cannot be started: {error.strerror}"
    except subprocess.CalledProcessError as error:
        lines = error.stderr.decode(errors="replace").strip().splitlines() or [f"exit code {error.returncode}"]
        return f"{program} fails: {lines[-1]}; it must be version 0.8 or later, and the kernel must allow namespaces"
    return None


def _runtime() -> Iterator[Path]:
    """Yield the paths that every isolated agent may see: programs and settings of the system, Python, packages."""
    yield from map(Path, _SYSTEM)
    for pattern in _SETTINGS:
        yield from Path("/etc").glob(pattern)
    for prefix in (sys.base_prefix, sys.base_exec_prefix, sys.prefix, sys.exec_prefix):
        for folder in (Path(prefix), Path(prefix).resolve()):
            environment = (folder / "pyvenv.cfg").exists()  # other agents and a store may lie next to its folders
            yield from (folder / name for name in _ENVIRONMENT) if environment else (folder,)
    yield from (path for path in map(Path, sys.path) if path.name in {"site-packages", "dist-packages"})
    yield from _links(Path(sys.executable))
    yield Path(catch_arena.__file__).parent
    yield from map(Path, catch_arena.agents.__path__)


def visible_paths(spec: str) -> Iterator[Path]:
    """Yield the files and folders that the agent of this spec sees: those of every agent, and its own."""
    yield from _runtime()
    if (words := command_of(spec)) is not None:
        yield from _command_paths(words)
    elif (folder := folder_of(spec)) is not None:
        yield folder
    elif (file := file_of(spec)) is not None:
        yield from _of_one_stem(file)
    else:
        yield from _package_folders(spec)


def _of_one_stem(file: Path) -> Iterator[Path]:
    """Yield a file, and the files in its folder with the same stem and another ending.

    A link next to the file is left out: it may lead to a file that the agent must not see.
    """
    yield file
    for other in file.parent.iterdir() if file.parent.is_dir() else ():
        if other.stem == file.stem and other.is_file() and not other.is_symlink():
            yield other


def _command_paths(words: Sequence[str]) -> Iterator[Path]:
    """Yield the files and folders that a command names, and the runtime of its program."""
    program, *arguments = words
    for link in _links(Path(program)):
        yield link
        if link.parent.name == "bin":  # such as a Java or a Node.js with its own folder
            yield from (link.parents[1] / name for name in ("conf", "lib", "lib64", "libexec"))
    for part in (part for word in arguments for part in re.split("[=:]", word)):
        path = Path(part)
        if path.is_absolute() and path.exists():
            yield from [path] if path.is_dir() else _of_one_stem(path)


def _package_folders(spec: str) -> Iterator[Path]:
    """Yield the folders or the file of the package of `package.module:Class`, without running its code."""
    try:
        found = importlib.util.find_spec(spec.partition(":")[0].partition(".")[0])
    except (ImportError, ValueError):
        found = None
    if found is not None and found.submodule_search_locations is not None:
        yield from map(Path, found.submodule_search_locations)
    elif found is not None and found.has_location and found.origin:
        yield Path(found.origin)


def _links(path: Path) -> Iterator[Path]:
    """Yield a file, and the files that it leads to, one link after the other."""
    yield path
    while path.exists() and path.is_symlink():
        path = Path(os.path.normpath(path.parent / path.readlink()))
        yield path
