"""Namespaces by bubblewrap: the command line that starts an agent's fork server in them, and whether they work here.

In them an agent has a network without anybody, processes of its own, and a file system of what it needs, read-only,
with small places in memory to write to. It is not root there, cannot become it, and cannot make further namespaces.
"""

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Final

from catch_arena.descendants import LINUX
from catch_arena.tournament.isolation.visible_files import VisibleFiles

PROGRAM: Final = "bwrap"
TEMPORARY: Final = Path("/tmp")  # noqa: S108 - in a file system of its own
SHARED: Final = Path("/dev/shm")  # noqa: S108
WRITABLE: Final = (TEMPORARY, SHARED)
"""The folders that an agent can write to."""
PLAY: Final = TEMPORARY / "match"
"""Where it works."""
_NOBODY: Final = 65534
_PROBE_S: Final = 20.0
_SETTINGS: Final = Path("/proc/sys")
_OPTIONS: Final = (
    *("--unshare-user", "--unshare-pid", "--unshare-net", "--unshare-ipc", "--unshare-uts", "--unshare-cgroup-try"),
    *("--uid", f"{_NOBODY}", "--gid", f"{_NOBODY}", "--hostname", "arena"),
    *("--disable-userns", "--cap-drop", "ALL", "--new-session", "--die-with-parent", "--as-pid-1"),
)
_REASONS: Final = (
    ("kernel/unprivileged_userns_clone", "0", "sysctl kernel.unprivileged_userns_clone=1 allows user namespaces"),
    ("user/max_user_namespaces", "0", "sysctl user.max_user_namespaces=10000 allows user namespaces"),
    (
        "kernel/apparmor_restrict_unprivileged_userns",
        "1",
        "AppArmor must allow it user namespaces: sysctl kernel.apparmor_restrict_unprivileged_userns=0, or a profile",
    ),
)
"""Settings of the kernel that keep people from user namespaces, and what would help."""


def bubblewrap_words(files: VisibleFiles, writable_bytes: int) -> list[str]:
    """What follows `bwrap`, up to the program that it starts.

    Args:
        files: what is seen.
        writable_bytes: how much each of the folders in WRITABLE holds.
    """
    size = ["--size", str(writable_bytes), "--tmpfs"]
    words = [*_OPTIONS, "--proc", "/proc", "--dev", "/dev", *size, str(SHARED), "--remount-ro", "/dev"]
    words += [*size, str(TEMPORARY)]
    paths = {*files.shown, *files.links}
    read_only = {path.parent for path in paths if path.is_relative_to(TEMPORARY)}  # as it is elsewhere
    for path in sorted(paths | read_only):  # folders come before what lies in them
        if path in read_only - paths:
            words += ["--tmpfs", str(path)]
        elif path in files.links:
            words += ["--symlink", files.links[path], str(path)]
        else:
            words += ["--ro-bind-try", str(path), str(path)]
    for path in sorted(files.masked):
        words += (
            ["--tmpfs", str(path), "--remount-ro", str(path)] if path.is_dir() else ["--ro-bind", os.devnull, str(path)]
        )
    words += [word for path in sorted((read_only - paths) | {Path("/")}) for word in ("--remount-ro", str(path))]
    return [*words, "--chdir", str(TEMPORARY)]


def namespaces_missing() -> str | None:
    """Why agents cannot have namespaces of their own here, in one line; None where they can."""
    return _missing(shutil.which(PROGRAM))


@cache
def _missing(program: str | None) -> str | None:
    if not LINUX:
        return f"{sys.platform} has none: only Linux does"
    if program is None:
        return "bubblewrap is not installed: apt-get install bubblewrap, or your system's package of that name"
    files = VisibleFiles()
    for path in map(Path, ("/usr", "/bin", "/lib", "/lib64", "/nix/store", "/gnu/store")):
        files.add(path)
    true = shutil.which("true") or "/bin/true"
    files.add(Path(true))
    try:
        subprocess.run(  # noqa: S603 - a program of the system
            [program, *bubblewrap_words(files, 1 << 20), "--", true],
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
        said = error.stderr.decode(errors="replace").strip().splitlines()
        return "; ".join([f"{program} fails: {said[-1] if said else f'exit code {error.returncode}'}", *_hints(said)])
    return None


def _hints(said: Sequence[str]) -> list[str]:
    if any("Unknown option" in line for line in said):
        return ["it must be version 0.8 or later"]
    return [hint for name, value, hint in _REASONS if _setting(name) == value]


def _setting(name: str) -> str | None:
    try:
        return (_SETTINGS / name).read_text().strip()
    except OSError:
        return None
