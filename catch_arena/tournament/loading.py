"""Import of agents in Python, and instances of their classes."""

import copy
import hashlib
import importlib
import importlib.util
import os
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, Final, get_args

from catch_arena.config import Control
from catch_arena.errors import AgentError, ConfigError, reason, suggest
from catch_arena.policy import Policy, PreyPolicy, Side
from catch_arena.text import shortened
from catch_arena.tournament.agent_spec import (
    COMMAND,
    IN_FOLDER,
    SHIPPED,
    file_of,
    folder_of,
    ladder_names,
    shipped_names,
)

NOT_INSTALLED: Final = "which is not installed here"
"""Part of the error for a missing module that an agent imports."""
_PREY: Final = "Prey"
_ENCODING_ERRORS: Final = ("'utf-8' codec", "Non-UTF-8", "null bytes")
"""Parts of Python's errors about a source file in another encoding than UTF-8."""
in_own_process = False  # True in the process of an isolated agent
_FILE_MODULE: Final = "catch_arena_agent_"
"""Prefix of the name of the module in an agent's file."""


def shipped(*, ladder: bool = False) -> dict[str, str]:
    """Return the agents that come with the package, or the frozen learned ones, by name, with one line about each."""
    names = ladder_names() if ladder else shipped_names()
    return {name: (load_module(f"{SHIPPED}.{name}").__doc__ or "").partition("\n")[0] for name in names}


def create_policy(spec: str, side: Side = "hunter") -> Policy | PreyPolicy:
    """Return a new instance of an agent that can play on that side, or raise AgentError with the reason."""
    found, folder = agent_class(spec, side), folder_of(spec)
    own = None if folder is None else _OWN.get(folder)
    try:
        with own or nullcontext():
            policy: Any = found()
            control = getattr(policy, "control", "target" if side == "hunter" else None)
    except (Exception, SystemExit) as error:  # a stranger's code may raise anything
        raise AgentError(f"{spec}: {found.__name__}() raised {reason(error)}") from error
    for method in ("reset", "act"):
        if not callable(getattr(policy, method, None)):
            raise AgentError(f"{spec}: {found.__name__} must have a method {method}")
    allowed: tuple[str | None, ...] = get_args(Control)
    rule = "control must be target, velocity or full"
    if side == "prey":
        allowed, rule = (None, "velocity"), "Prey.control must be velocity or be left out (R12.2)"
    if not isinstance(control, str | None) or control not in allowed:  # an array would give no bool
        raise AgentError(f"{spec}: {rule}, got {shortened(control)}")
    made: Policy | PreyPolicy = policy if own is None else _InFolder(policy, own)
    return made


def sources_and_prey(spec: str) -> tuple[tuple[str, ...], bool]:
    """Return the files of an agent's module and of its classes, and whether it plays prey itself."""
    module = agent_module(spec)
    homes = [getattr(one, "__module__", None) for one in (agent_class(spec), getattr(module, _PREY, None))]
    modules = [module, *(sys.modules.get(home) for home in homes if isinstance(home, str))]
    files = [getattr(one, "__file__", None) for one in modules]
    return tuple(dict.fromkeys(file for file in files if isinstance(file, str))), hasattr(module, _PREY)


@cache
def agent_module(spec: str) -> ModuleType:
    """Return the module with the class of a spec; it is imported once, also for processes that are forked later."""
    if spec.startswith(COMMAND):
        raise ConfigError(f"{spec}: a command plays in a process of its own only: it must not be trusted")
    if (file := file_of(spec)) is not None:
        return load_file(file, folder_of(spec))
    return load_module(spec.partition(":")[0])


def agent_class(spec: str, side: Side = "hunter") -> type:
    """Return the class of a spec, or the class `Prey` next to it; raise AgentError if it cannot be imported."""
    module = agent_module(spec)
    name = _PREY if side == "prey" else "Agent" if file_of(spec) is not None else spec.partition(":")[2]
    found = getattr(module, name, None)
    if not isinstance(found, type):
        classes = [key for key, value in vars(module).items() if isinstance(value, type)]
        raise AgentError(f"{spec}: has no class {name}{'; ' + suggest(name, classes) if classes else ''}")
    return found


def module_folders() -> list[str]:
    """Return the folders for the imports of agents: `sys.path` without the folder that a command started in."""
    here = sys.path[:1] in ([""], [str(Path.cwd())])
    return [str(Path(entry).absolute()) for entry in sys.path[here:] if entry]


def load_module(name: str) -> ModuleType:
    """Return the installed module with a dotted name, or raise AgentError if its import raises anything."""
    try:
        with _process_restored():
            return importlib.import_module(name)
    except (Exception, SystemExit) as error:  # a stranger's code may raise anything
        raise AgentError(f"{name}: {_why_not_imported(error, name)}") from error


def load_file(path: Path, folder: Path | None = None) -> ModuleType:
    """Return the module in a .py file, which can import others from `folder`; raise AgentError if its import raises."""
    name = f"{_FILE_MODULE}{hashlib.blake2b(str(path).encode(), digest_size=8).hexdigest()}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise AgentError(f"{path}: is no Python file")
    module = sys.modules[name] = importlib.util.module_from_spec(spec)  # dataclasses need their module in sys.modules
    try:
        with _process_restored():
            own = None if folder is None or str(folder) in sys.path else _OwnModules(folder)
            with own or nullcontext():
                spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:  # a stranger's code may raise anything
        del sys.modules[name]
        why = _why_not_imported(error, path.stem, path.parent if folder is None else None)
        if isinstance(error, SyntaxError | ValueError) and any(words in str(error) for words in _ENCODING_ERRORS):
            why = "is not UTF-8: save it as UTF-8"
        raise AgentError(f"{path}: {why}") from error
    if own is not None and folder is not None:
        _OWN[folder] = own
    return module


@contextmanager
def _process_restored() -> Iterator[None]:
    """Search modules in `module_folders` only; then restore the working folder, the standard streams and `sys.path`."""
    if in_own_process:  # it keeps what the module has made of them
        yield
        return
    path, folder = sys.path[:], Path.cwd()
    streams = sys.stdin, sys.stdout, sys.stderr
    sys.path[:] = module_folders()
    try:
        yield
    finally:
        sys.path[:] = path
        os.chdir(folder)
        sys.stdin, sys.stdout, sys.stderr = streams


class _OwnModules(AbstractContextManager[None]):
    """Context in which an agent imports modules from its folder, as often as it is entered.

    They are removed at its end, since another agent's may have the same names.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = str(folder)
        self._modules: dict[str, ModuleType] = {}
        self._replaced: dict[str, ModuleType] = {}
        self._known = 0

    def __enter__(self) -> None:
        sys.path.insert(0, self._folder)
        self._replaced = {name: sys.modules[name] for name in self._modules if name in sys.modules}
        sys.modules.update(self._modules)
        self._known = len(sys.modules)

    def __exit__(self, *_: object) -> None:
        if self._folder in sys.path:  # the agent may have changed it
            sys.path.remove(self._folder)
        new = list(sys.modules)[self._known :] if len(sys.modules) > self._known else ()  # they come last
        self._modules |= {name: sys.modules[name] for name in new if self._has(sys.modules[name])}
        for name in self._modules:
            sys.modules.pop(name, None)
        sys.modules.update(self._replaced)

    def _has(self, module: ModuleType) -> bool:
        """Return whether a module, or a package without an `__init__.py`, is in the folder."""
        if (spec := getattr(module, "__spec__", None)) is None or spec.name.startswith(_FILE_MODULE):
            return False
        places = (spec.origin, *(spec.submodule_search_locations or ()))
        return any(Path(place).is_relative_to(self._folder) for place in places if place is not None)


_OWN: Final[dict[Path, _OwnModules]] = {}
"""Contexts of agents that play in this process, by folder; in an agent's own process `sys.path` has the folder."""


class _InFolder:
    """Instance of an agent that can import modules from its folder whenever it is called."""

    def __init__(self, policy: Any, own: _OwnModules) -> None:
        self._policy, self._own = policy, own

    def reset(self, seed: int) -> None:
        with self._own:
            self._policy.reset(seed)

    def act(self, view: Any) -> Any:
        with self._own:
            return self._policy.act(view)

    def __deepcopy__(self, memo: dict[int, Any]) -> "_InFolder":
        return _InFolder(copy.deepcopy(self._policy, memo), self._own)  # copies share the modules

    def __getattr__(self, name: str) -> Any:
        if name not in {"act_batch", "control"}:
            raise AttributeError(name)
        return getattr(self._policy, name)


def _why_not_imported(error: BaseException, module: str, folder: Path | None = None) -> str:
    """Return an import's error in words; `folder` holds an agent's single file, and is None for other agents."""
    missing = error.name if isinstance(error, ModuleNotFoundError) else None
    if missing is None:
        return f"importing it raised {reason(error)}"
    if module == missing or module.startswith(f"{missing}."):
        file = Path(*module.split(".")).with_suffix(".py")
        return f"no module {missing} is installed" + (f"; a file is given with its ending, as {file}" * file.is_file())
    top = missing.partition(".")[0]
    own = "" if folder is None else f"; if {top} is a file of yours, give a folder with {IN_FOLDER} and {top}.py"
    return f"it imports {missing}, {NOT_INSTALLED}{own}"
