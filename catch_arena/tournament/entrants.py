"""Who plays: an agent's spec, as on the command line, becomes an entrant, which was looked at and has a name."""

import hashlib
import importlib
import importlib.util
import locale
import os
import pkgutil
import shlex
import shutil
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from functools import cache
from inspect import signature
from pathlib import Path
from stat import S_ISREG
from types import ModuleType
from typing import Any, Final, NamedTuple

from catch_arena.config import Control
from catch_arena.errors import AgentError, CatchArenaError, reason, suggest
from catch_arena.files import is_loop, wide_text_fault
from catch_arena.policy import Policy, PreyPolicy, Side, control_of
from catch_arena.text import composed, name_fault, one_line

COMMAND: Final = "cmd:"
"""What the spec of a command begins with."""
NOT_INSTALLED: Final = "which is not installed here"
"""What is said of a module that an agent imports, and that is not there."""
_SHIPPED: Final = "catch_arena.agents"
SHIPPED_PREY: Final = "flee"
"""Who plays prey for an agent that does not."""
_PREY: Final = "Prey"
"""What the class is called that plays prey."""
_IN_FOLDER: Final = "agent.py"
"""The file with the class `Agent`, if an agent is a folder."""
_FILE_MODULE: Final = "catch_arena_agent_"
"""Begin of the name that the module in an agent's file has."""
_LARGEST_SOURCE: Final = 1 << 26
"""Bytes of a file that is taken for a module's source."""
_GENERIC: Final = frozenset({"agent", "bot", "main", "player", "solution", "submission"})
"""Names of files that do not tell one agent from another: the folder's name is put before them."""
_MOST_SOURCES: Final = 3
"""Files of an agent: its module's, and those of its two classes."""


@dataclass(frozen=True, slots=True)
class Entrant:
    """One agent in a tournament; it can be sent to another process, which makes its own instances."""

    name: str
    """Unique in its tournament: `nearest`, and `nearest#2` if it plays against itself; `ann/agent` for a file with a
    generic name, and `ann/mine` and `bob/mine` if two files have one name.
    """
    spec: str
    """Absolute path of a file or folder, `package.module:Class`, or `cmd:` and a command with absolute paths."""
    control: Control
    digest: str
    """16 hexadecimal digits of the bytes of its files (`sources_of`), with what a network has learned beside them; of a
    command, of its words and of the files that they name.
    """
    fault: str | None = None
    """Why it cannot play, where that showed when it was looked at in isolation: it forfeits all its matches."""
    prey: bool = False
    """R12.7: whether it plays prey itself; else a shipped one plays there."""
    prey_digest: str = ""
    """That of who plays prey for it: its own, or the shipped one's."""
    side: Side = "hunter"
    """What it plays in a match; no part of what is known of it."""

    @property
    def facts(self) -> dict[str, Any]:
        """What is known of it, as it is stored."""
        known = {name: getattr(self, name) for name in self.__dataclass_fields__}
        del known["side"]
        return known

    @property
    def needs_prey(self) -> bool:
        """Whether the shipped prey plays for it: it has none of its own, and nothing else keeps it from playing."""
        return not self.prey and self.fault is None

    def on(self, side: Side) -> "Entrant":
        """Who plays for it on a side, under the name that tells so."""
        if side == self.side:
            return self
        found = replace(self, control="velocity", side=side)
        if not self.needs_prey:
            return found
        name, spec = f"{self.name} (plays {SHIPPED_PREY})", _shipped_spec(SHIPPED_PREY)
        return replace(found, name=name, spec=spec, digest=self.prey_digest)

    @property
    def source(self) -> str:
        """Where it comes from, for everybody: a file's name without its folders, and of a command its program."""
        try:
            if (words := command_of(self.spec)) is not None:
                return f"a command: {Path(words[0]).name}"
        except (ValueError, IndexError):  # a store may say anything
            return "a command"
        return self.spec if file_of(self.spec) is None else Path(self.spec).name

    def create(self) -> Policy | PreyPolicy:
        """A fresh instance in this process, for one match.

        Raises:
            AgentError: where it cannot be loaded or made.
        """
        return create_policy(self.spec, self.side)


@dataclass(frozen=True, slots=True)
class Inspection:
    """What an agent says of itself."""

    control: Control = "target"
    sources: tuple[str, ...] = ()
    """The files that it consists of: `sources_of`."""
    fault: str | None = None
    """Why it cannot play."""
    log: str = ""
    """What it printed meanwhile."""
    prey: bool = False
    """Whether it plays prey itself."""


def shipped() -> dict[str, str]:
    """The agents that come with the package: name to one line about each."""
    package = load_module(_SHIPPED)
    names = sorted(module.name for module in pkgutil.iter_modules(package.__path__))
    return {name: (load_module(f"{_SHIPPED}.{name}").__doc__ or "").partition("\n")[0] for name in names}


def inspect_agent(spec: str) -> Inspection:
    """An agent looked at in this process.

    Raises:
        AgentError: where it cannot play.
    """
    policy = create_policy(spec)
    return Inspection(control_of(policy), sources_of(spec), prey=has_prey(spec))


def enter(specs: Sequence[str], inspect: Callable[[str], Inspection] = inspect_agent) -> tuple[Entrant, ...]:
    """The entrants that these specs stand for, in their order.

    Args:
        specs: shipped names, `package.module:Class`, paths of .py files with a class `Agent` or of folders with
            such an agent.py, or `cmd:` and a command.
        inspect: looks at an agent, in this process or (`isolation.playing.inspector`) in one of its own.

    Raises:
        AgentError: one line, that names the spec and what is wrong with it.
    """
    seen: Counter[str] = Counter()
    names: set[str] = set()
    inspections: dict[str, Inspection] = {}
    entrants = []
    resolved = [_resolve(spec) for spec in specs]
    for one, name in zip(resolved, _unique_names(resolved), strict=True):
        if any("\ud800" <= character <= "\udfff" for character in one.spec):  # how Python reads bytes that are no text
            raise AgentError(
                f"{one.spec!a}: must be text in this system's encoding, {sys.getfilesystemencoding()}: "
                "give the file or its folder another name, or try LANG=C.UTF-8"
            )
        seen[name] += 1
        while (unique := name if seen[name] == 1 else f"{name}#{seen[name]}") in names:
            seen[name] += 1  # a file may be called like that
        names.add(unique)
        if (wrong := name_fault(unique)) is not None:
            raise AgentError(f"{one.spec!a}: {wrong}: give the file another name")
        if one.spec not in inspections:
            inspections[one.spec] = inspect(one.spec)
        found = inspections[one.spec]
        digest = _digest(one, found.sources)
        fault = None if found.fault is None else one_line(found.fault)
        entrant = Entrant(unique, one.spec, found.control, digest, fault, found.prey, digest)
        entrants.append(replace(entrant, prey_digest=_shipped_prey_digest()) if entrant.needs_prey else entrant)
    return tuple(entrants)


def create_policy(spec: str, side: Side = "hunter") -> Policy | PreyPolicy:
    """A new instance of an agent that can play on that side.

    Raises:
        AgentError: that says why it cannot.
    """
    found = agent_class(spec, side)
    try:
        policy: Policy | PreyPolicy = found()
    except (Exception, SystemExit) as error:  # a stranger's code may raise anything
        raise AgentError(f"{spec}: {found.__name__}() raised {reason(error)}") from error
    for method, argument in (("reset", "seed"), ("act", "view")):
        if not callable(getattr(policy, method, None)):
            raise AgentError(f"{spec}: {found.__name__} must have a method {method}")
        if not _takes_one_argument(getattr(policy, method)):
            raise AgentError(
                f"{spec}: {found.__name__}.{method} must take one argument: def {method}(self, {argument})"
            )
    control = getattr(policy, "control", None)
    if side == "prey":
        if control not in {None, "velocity"}:
            raise AgentError(f"{spec}: Prey.control must be velocity or be left out (R12.2), got {control!r}")
        return policy
    try:
        control_of(policy)
    except CatchArenaError:
        raise AgentError(f"{spec}: control must be target, velocity or full, got {control!r}") from None
    return policy


def has_prey(spec: str) -> bool:
    """Whether an agent in Python plays prey itself; none is made.

    Raises:
        AgentError: where its module cannot be used.
    """
    return hasattr(agent_module(spec), _PREY)


def is_shipped(spec: str) -> bool:
    """Whether an agent comes with the package: our own code, which needs no process of its own."""
    return spec.startswith(f"{_SHIPPED}.")


def sources_of(spec: str) -> tuple[str, ...]:
    """The files that an agent in Python consists of: its module's, and those that its classes come from.

    Raises:
        AgentError: where its module cannot be used, or has no such class.
    """
    module = agent_module(spec)
    homes = [getattr(one, "__module__", None) for one in (agent_class(spec), getattr(module, _PREY, None))]
    modules = [module, *(sys.modules.get(home) for home in homes if isinstance(home, str))]
    files = [getattr(one, "__file__", None) for one in modules]
    return tuple(dict.fromkeys(file for file in files if isinstance(file, str)))


def folder_of(spec: str) -> Path | None:
    """Return the folder of an agent that is a folder with an agent.py; None for all others."""
    return Path(spec) if Path(spec).is_absolute() and not spec.endswith(".py") else None


def file_of(spec: str) -> Path | None:
    """Return the file with the class of an agent in a file or folder; None for modules and commands."""
    folder = folder_of(spec)
    return folder / _IN_FOLDER if folder is not None else Path(spec) if spec.endswith(".py") else None


def command_of(spec: str) -> list[str] | None:
    """The words of a command, its program first; None for an agent in Python."""
    return shlex.split(spec.removeprefix(COMMAND)) if spec.startswith(COMMAND) else None


@cache
def agent_module(spec: str) -> ModuleType:
    """Where the class is that a spec stands for, imported once: whatever asks for it, and in all that is forked since.

    Raises:
        AgentError: for a command, and a module that cannot be imported.
    """
    if spec.startswith(COMMAND):
        raise AgentError(f"{spec}: a command plays in a process of its own only: it must not be trusted")
    if (file := file_of(spec)) is not None:
        return load_file(file, folder_of(spec))
    return load_module(spec.partition(":")[0])


def agent_class(spec: str, side: Side = "hunter") -> type:
    """The class that a spec stands for; that of its prey stands beside it.

    Raises:
        AgentError: for a command, a module that cannot be imported, and one without that class.
    """
    module = agent_module(spec)
    name = _PREY if side == "prey" else "Agent" if file_of(spec) is not None else spec.partition(":")[2]
    found = getattr(module, name, None)
    if not isinstance(found, type):
        classes = [key for key, value in vars(module).items() if isinstance(value, type)]
        raise AgentError(f"{spec}: has no class {name}{'; ' + suggest(name, classes) if classes else ''}")
    return found


def module_folders() -> list[str]:
    """Return where the modules of agents are searched: all of `sys.path` but the folder that a command started in."""
    here = sys.path[:1] in ([""], [str(Path.cwd())])
    return [str(Path(entry).absolute()) for entry in sys.path[here:] if entry]


def load_module(name: str) -> ModuleType:
    """Return the installed module with a dotted name.

    Raises:
        AgentError: if importing it raises.
    """
    try:
        with _process_restored():
            return importlib.import_module(name)
    except (Exception, SystemExit) as error:  # a stranger's code may raise anything
        raise AgentError(f"{name}: {_why_not_imported(error, name)}") from error


def load_file(path: Path, folder: Path | None = None) -> ModuleType:
    """Return the module in a .py file.

    Args:
        path: the file.
        folder: the folder in which it finds further modules, while it is imported; None for none.

    Raises:
        AgentError: if importing it raises.
    """
    name = f"{_FILE_MODULE}{hashlib.blake2b(str(path).encode(), digest_size=8).hexdigest()}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise AgentError(f"{path}: is no Python file")
    module = sys.modules[name] = importlib.util.module_from_spec(spec)  # dataclasses look their module up
    try:
        with _process_restored(), nullcontext() if folder is None else _modules_of(folder):
            spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:  # a stranger's code may raise anything
        del sys.modules[name]
        fault = wide_text_fault(_content_of(str(path)) or b"")
        why = fault or _why_not_imported(error, path.stem, path.parent if folder is None else None)
        raise AgentError(f"{path}: {why}") from error
    return module


def resolve_spec(spec: str) -> str:
    """An entrant's spec, from one as on the command line: from any folder it stands for the same.

    Raises:
        AgentError: where it names no agent.
    """
    return _resolve(spec).spec


class _Resolved(NamedTuple):
    """What a spec stands for."""

    spec: str
    path: tuple[str, ...]
    """Its name comes last, what holds it before that."""
    content: bytes | None = None
    """What its digest is of, as far as that is known without a look at the agent: of a command all."""


def _resolve(spec: str) -> _Resolved:
    if spec.startswith(COMMAND):
        return _resolve_command(spec)
    if (file := spec.rpartition(":")[0]).endswith(".py"):
        raise AgentError(f"{spec}: a file is given alone, and its class is called Agent: {file}")
    path = Path(os.path.abspath(Path(spec).expanduser()))  # noqa: PTH100 - absolute() keeps ".."; links stay
    is_path = os.sep in spec or spec.endswith(".py")
    if not is_path and spec in (known := shipped()):
        return _Resolved(_shipped_spec(spec), (spec,))
    if is_path or os.path.lexists(path):
        return _resolve_path(spec, path)
    if ":" in spec:
        return _Resolved(spec, tuple(spec.replace(":", ".").split(".")))
    raise AgentError(
        f"unknown agent {spec!r}: {suggest(spec, known)} "
        f"(or give a .py file, a folder with {_IN_FOLDER}, package.module:Class, or {COMMAND}COMMAND)"
    )


def _resolve_path(spec: str, path: Path) -> _Resolved:
    """Resolve a file or folder.

    Args:
        spec: as it was given.
        path: its absolute path.
    """
    if path.is_dir():
        if not (path / _IN_FOLDER).is_file():
            raise AgentError(f"{spec}: is a folder without {_IN_FOLDER}, which holds the class Agent")
        return _Resolved(str(path), tuple(map(composed, path.parts[1:])), _digest_of_folder(path))
    if not path.is_file():
        why = "is a link that leads to no file" if path.is_symlink() else "no such file"
        raise AgentError(f"{spec}: {'is a link that leads to itself' if is_loop(path) else why}")
    content = path.read_bytes()
    if path.suffix == ".ipynb" or (content.lstrip().startswith(b"{") and b'"cells"' in content):
        raise AgentError(f"{spec}: is a notebook; save the code of its agent as a .py file with a class Agent")
    if path.suffix != ".py":
        right = path.with_suffix(".py").name
        hint = f"rename it to {right}" if path.suffix.lower() == ".py" else "other programs are given as cmd:COMMAND"
        raise AgentError(f"{spec}: must be a .py file or a folder with {_IN_FOLDER}; {hint}")
    return _Resolved(str(path), _name_parts(path), content + _beside(path))


def _shipped_spec(name: str) -> str:
    return f"{_SHIPPED}.{name}:Agent"


@cache
def _shipped_prey_digest() -> str:
    spec = _shipped_spec(SHIPPED_PREY)
    return _digest(_Resolved(spec, ()), sources_of(spec))


def _digest(agent: _Resolved, sources: Sequence[str]) -> str:
    """Of the files that an agent says it consists of, its own first; where none can be read, of its spec."""
    found = [] if agent.content is None else [agent.content]
    if not agent.spec.startswith(COMMAND) and folder_of(agent.spec) is None:
        for source in sources[:_MOST_SOURCES]:
            content = _content_of(source)
            if content is not None and source != agent.spec:
                found.append(content + _beside(Path(source)))
    return hashlib.blake2b(b"\0".join(found or [agent.spec.encode()]), digest_size=8).hexdigest()


def _content_of(source: str) -> bytes | None:
    """What is in a file that an agent says is its own; None where there is nothing to be read. It may say any."""
    try:
        # a pipe that nobody writes to is not waited for
        with os.fdopen(os.open(source, os.O_RDONLY | os.O_NONBLOCK), "rb") as file:
            return file.read(_LARGEST_SOURCE) if S_ISREG(os.fstat(file.fileno()).st_mode) else None
    except (OSError, ValueError):
        return None


def _digest_of_folder(folder: Path) -> bytes:
    """Return a digest of the names and contents of its files, without `__pycache__` and what begins with a dot."""
    paths = (path.relative_to(folder) for path in sorted(folder.rglob("*")))
    kept = (path for path in paths if not any(part[0] == "." or part == "__pycache__" for part in path.parts))
    digest = hashlib.blake2b()  # a folder may hold more than memory does
    for path in kept:
        digest.update(os.fsencode(path) + b"\0" + (_content_of(str(folder / path)) or b"") + b"\0")
    return digest.digest()


def _beside(path: Path) -> bytes:
    """What a network has learned, where it lies beside the agent's file under its name: `mine.npz` beside `mine.py`."""
    return b"".join(_content_of(str(path.with_suffix(suffix))) or b"" for suffix in _WEIGHTS)


_WEIGHTS: Final = (".npz", ".npy", ".safetensors", ".onnx", ".pt", ".pth")


def _name_parts(file: Path) -> tuple[str, ...]:
    parts = file.parts[1:-1]
    if file.name != "__init__.py" or not parts:  # that of a package, which is called as its folder
        parts = (*parts, file.stem)
    return tuple(map(composed, parts))


def _unique_names(agents: Sequence[_Resolved]) -> list[str]:
    """Return a name for each: the last part of its path, and as many before that as tell it from other paths."""
    depths = {one.path: 2 if one.path[-1] in _GENERIC else 1 for one in agents}

    def name(path: tuple[str, ...]) -> str:
        return "/".join(path[-depths[path] :])

    for _ in range(max(map(len, depths), default=0)):
        often = Counter(map(name, depths))
        for path in [path for path in depths if often[name(path)] > 1]:
            depths[path] += 1
    return [name(one.path) for one in agents]


def _resolve_command(spec: str) -> _Resolved:
    """A command, with the files that it names under their whole paths: it is started in another folder."""
    try:
        words = shlex.split(spec.removeprefix(COMMAND))
    except ValueError as error:
        raise AgentError(f"{spec}: must be a command as a shell takes it: {error}") from None
    if not words:
        raise AgentError(f"{spec}: must name a command, as in {COMMAND}./my_bot")
    named = {word: Path(os.path.abspath(path)) for word in words if (path := Path(word).expanduser()).exists()}  # noqa: PTH100
    files = {word: path for word, path in named.items() if path.is_file()}
    program, *arguments = [str(named.get(word, word)) for word in words]
    if words[0] in files:
        _require_program(words[0], files[words[0]])
    found = shutil.which(program)
    if found is None:
        raise AgentError(f"{spec}: {words[0]} is no program that can be run")
    contents = (_digest_of_folder(path) if path.is_dir() else path.read_bytes() for path in named.values())
    content = b"\0".join([*(word.encode() for word in words if word not in named), *contents])
    parts = _name_parts(next(iter(files.values()), Path(Path(program).name)))
    return _Resolved(COMMAND + shlex.join([found, *arguments]), parts, content)


def _require_program(word: str, path: Path) -> None:
    """Require that a file can be started as a program.

    Raises:
        AgentError: that says what is wrong with it.
    """
    if not os.access(path, os.X_OK):
        raise AgentError(f"{word}: must be executable: chmod +x {word}")
    first = (_content_of(str(path)) or b"").partition(b"\n")[0]
    if not first.startswith(b"#!"):
        return
    if first.endswith(b"\r"):
        raise AgentError(f"{word}: its lines end as on Windows (CR LF): sed -i 's/\\r$//' {word}")
    interpreter, *options = os.fsdecode(first[2:]).split() or [""]
    needed = options[-1] if Path(interpreter).name == "env" and len(options) == 1 else interpreter
    if shutil.which(needed) is None:
        raise AgentError(f"{word}: its first line names the interpreter {needed!r}, which is not installed here")


def _takes_one_argument(method: Callable[..., object]) -> bool:
    try:
        signature(method).bind(None)
    except TypeError:
        return False
    except ValueError:  # some callables tell no signature
        return True
    return True


@contextmanager
def _process_restored() -> Iterator[None]:
    """Search modules in `module_folders` alone, and restore what a stranger's module may change while it is imported:
    the folder, the streams, the locale, and where modules are found.
    """
    path, folder, language = sys.path[:], Path.cwd(), locale.setlocale(locale.LC_ALL)
    streams = sys.stdin, sys.stdout, sys.stderr
    sys.path[:] = module_folders()
    try:
        yield
    finally:
        sys.path[:] = path
        os.chdir(folder)
        locale.setlocale(locale.LC_ALL, language)
        sys.stdin, sys.stdout, sys.stderr = streams


@contextmanager
def _modules_of(folder: Path) -> Iterator[None]:
    """Let modules be imported from a folder, and forget them: another agent's may have the same names.

    In an agent's own process the folder is searched already, and they stay.
    """
    if str(folder) in sys.path:
        yield
        return
    before = set(sys.modules)
    sys.path.insert(0, str(folder))
    try:
        yield
    finally:
        for name in sys.modules.keys() - before:
            file = getattr(sys.modules[name], "__file__", None)
            if isinstance(file, str) and Path(file).is_relative_to(folder) and not name.startswith(_FILE_MODULE):
                del sys.modules[name]


def _why_not_imported(error: BaseException, module: str, folder: Path | None = None) -> str:
    """In words.

    Args:
        error: what was raised.
        module: that was to be imported.
        folder: the one that the file is in, where it is a file that plays alone.
    """
    missing = error.name if isinstance(error, ModuleNotFoundError) else None
    if missing is None or module == missing or module.startswith(f"{missing}."):
        return f"importing it raised {reason(error)}"
    top = missing.partition(".")[0]
    if folder is not None and ((folder / f"{top}.py").is_file() or (folder / top).is_dir()):
        return (
            f"it imports {missing}, which is next to it: an agent of several files is a folder with {_IN_FOLDER}, "
            "and is given as that folder (`catch-arena docs agents`)"
        )
    return f"it imports {missing}, {NOT_INSTALLED}"
