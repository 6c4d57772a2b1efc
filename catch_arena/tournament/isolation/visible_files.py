"""Which files an agent sees in a file system of its own: the interpreter, what is installed, and what is its own.

Of the folder that an agent's file lies in it sees all but what is another's: docs/isolation.md has the rule.
"""

import importlib.util
import os
import re
import shlex
import stat
import sys
import tempfile
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import catch_arena.agents
from catch_arena.tournament.entrants import COMMAND, is_shipped

_SYSTEM: Final = ("/usr", "/bin", "/sbin", "/lib", "/lib32", "/lib64", "/libx32", "/nix/store", "/gnu/store")
_SETTINGS: Final = (
    *("alternatives", "fonts", "java*", "jvm*", "ld.so.cache", "ld.so.conf", "ld.so.conf.d", "localtime", "magic"),
    *("mime.types", "nsswitch.conf", "os-release", "pki/tls/certs", "pki/tls/openssl.cnf", "ssl/certs"),
    *("ssl/openssl.cnf", "terminfo", "timezone"),
)
"""What programs read in /etc: not the machine's users, keys or names."""
_RUNTIME: Final = ("bin", "conf", "lib", "lib64", "libexec")
"""What belongs to a program in a folder `bin`: that, and these beside it."""
_INSTALLED: Final = {"site-packages", "dist-packages"}


@dataclass(slots=True)
class VisibleFiles:
    """What is seen, at the same places as outside; nothing else is there."""

    shown: set[Path] = field(default_factory=set)
    """Files, and folders with all that is in them."""
    links: dict[Path, str] = field(default_factory=dict)
    """Symbolic links, with what they say."""
    masked: set[Path] = field(default_factory=set)
    """What is left out of these folders."""

    def add(self, path: Path) -> None:
        """Show that, if it is there. Links on its way stay links, and what they lead to is shown."""
        if not path.exists():
            return
        for parent in (*reversed(path.parents), path):
            if self.covers(parent):
                return
            if parent.is_symlink():
                text = str(parent.readlink())
                self.links[parent] = text
                self.add(Path(os.path.normpath(parent.parent / text), path.relative_to(parent)))
                return
        self.shown.add(path)

    def covers(self, path: Path) -> bool:
        """Whether it lies in what is shown."""
        return any(parent in self.shown for parent in (path, *path.parents))


def visible_files(spec: str, entrants: Iterable[str] = (), hidden: Iterable[str] = ()) -> VisibleFiles:
    """What the agent of this spec sees, as things are now.

    Args:
        spec: an entrant's.
        entrants: the specs of all entrants: no agent sees what is another's.
        hidden: whole paths of files and folders that no agent sees.
    """
    files = VisibleFiles()
    for path in _runtime():
        files.add(path)
    own, secret = own_files(spec), {Path(path) for path in hidden}
    rivals = {path for other in entrants for path in own_files(other) if not _holds(path, own)}
    command, module = spec.startswith(COMMAND), not spec.endswith(".py")
    for path in _runtime_of(_words(spec)[0]) if command else _package_folders(spec) if module else ():
        files.add(path)
    for path in own:
        for entry in _entries(path, rivals, secret, alone=not command, shared=module and not command):
            if files.covers(entry):
                continue
            try:
                kind = stat.S_IFMT(entry.lstat().st_mode)
            except FileNotFoundError:  # it has just gone
                continue
            if kind == stat.S_IFLNK:  # whatever it leads to is not shown for its sake
                files.links[entry] = str(entry.readlink())
            elif kind in {stat.S_IFREG, stat.S_IFDIR}:
                files.shown.add(entry)
    files.masked = {
        path for path in rivals | secret if path.exists() and files.covers(path) and not _holds(path, files.shown)
    }
    return files


def own_files(spec: str) -> list[Path]:
    """The files and folders that are named by a spec, programs of the system and of runtimes left out."""
    if is_shipped(spec) or _holds_any(map(Path, catch_arena.agents.__path__), Path(spec)):
        return []
    if spec.startswith(COMMAND):
        program, *arguments = _words(spec)
        named = [part for word in arguments for part in re.split("[=:]", word)]
        own = [*([] if Path(program).parent.name == "bin" else [program]), *named]
        paths = [Path(word) for word in own if word.startswith("/")]
        return [path for path in paths if path.exists() and not _is_wide(path) and not _holds("/usr", [path])]
    if spec.endswith(".py"):
        return [Path(spec)]
    _, *inner = spec.partition(":")[0].split(".")
    places = [folder.joinpath(*inner) for folder in _package_folders(spec)]
    return [place if place.exists() else place.with_name(f"{place.name}.py") for place in places]


def _runtime() -> Iterator[Path]:
    """The system's programs, this interpreter and this package."""
    yield from map(Path, _SYSTEM)
    for pattern in _SETTINGS:
        yield from Path("/etc").glob(pattern)
    yield from map(Path, (sys.base_prefix, sys.base_exec_prefix, sys.prefix, sys.exec_prefix))
    yield from (path for path in map(Path, sys.path) if path.name in _INSTALLED)
    yield from _way_to(Path(sys.executable))
    yield Path(catch_arena.__file__).parent
    yield from map(Path, catch_arena.agents.__path__)


def _runtime_of(program: str) -> Iterator[Path]:
    """What a program needs that is installed elsewhere than the system's are."""
    for path in _way_to(Path(program)):
        yield path
        if path.parent.name == "bin" and not _is_wide(path.parent.parent):
            yield from (path.parent.parent / name for name in _RUNTIME)


def _way_to(path: Path) -> Iterator[Path]:
    """A file, and those that it leads to, one link after the other."""
    yield path
    while path.exists() and path.is_symlink():
        path = Path(os.path.normpath(path.parent / path.readlink()))
        yield path


def _package_folders(spec: str) -> list[Path]:
    """Where the package of `package.module:Class` lies, or the file of `module:Class`; nothing of it is run."""
    try:
        found = importlib.util.find_spec(spec.partition(":")[0].partition(".")[0])
    except (ImportError, ValueError):
        return []
    if found is None:
        return []
    if found.submodule_search_locations is not None:
        return list(map(Path, found.submodule_search_locations))
    return [Path(found.origin)] if found.has_location and found.origin else []


def _entries(
    path: Path, rivals: Collection[Path], secret: Collection[Path], *, alone: bool, shared: bool
) -> Iterator[Path]:
    """What an agent sees for this file or folder of its own: that, and what lies beside a file and is nobody else's.

    Args:
        path: the file or folder.
        rivals: what belongs to others.
        secret: what nobody sees.
        alone: whether a .py file beside it is another agent: an agent in one file imports nothing from there.
        shared: whether its folder holds much besides, so that only what has its name is its own.
    """
    yield path
    folder = path.parent
    if path.is_dir() or not path.exists():
        return
    try:
        entries = list(folder.iterdir())
    except OSError:
        return
    others = {rival.stem for rival in rivals if rival.parent == folder}
    others |= {entry.stem for entry in entries if alone and entry.suffix == ".py" and entry != path}
    shared = shared or _is_wide(folder) or _holds_any(secret, folder)
    for entry in entries:
        if entry == path or (alone and entry.suffix == ".py"):
            continue
        owners = [stem for stem in (path.stem, *others) if _begins_with(entry.name, stem)]
        owner = max(owners, key=len, default=None)
        nobodys = owner is None and not shared and not entry.name.startswith(".") and entry.name != "__pycache__"
        if (nobodys or owner == path.stem) and not _holds(entry, (*rivals, *secret)):
            yield entry


def _begins_with(name: str, stem: str) -> bool:
    return name.startswith(stem) and not name[len(stem) : len(stem) + 1].isalnum()


def _is_wide(folder: Path) -> bool:
    """Whether it holds much besides an agent: somebody's home, or temporary files."""
    places = os.path.expanduser("~"), tempfile.gettempdir()  # noqa: PTH111 - a user without a home is no error
    return _holds(folder, [Path(place).resolve() for place in places])


def _holds(folder: Path | str, paths: Iterable[Path]) -> bool:
    return any(path.is_relative_to(folder) for path in paths)


def _holds_any(folders: Iterable[Path], path: Path) -> bool:
    return any(path.is_relative_to(folder) for folder in folders)


def _words(spec: str) -> list[str]:
    return shlex.split(spec.removeprefix(COMMAND))
