"""Who plays: an agent's name on the command line becomes a checked, named entrant."""

import hashlib
import importlib
import importlib.util
import pkgutil
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType

from catch_arena.config import Control
from catch_arena.errors import AgentError, CatchArenaError, suggest
from catch_arena.policy import Policy, control_of


@dataclass(frozen=True, slots=True)
class Entrant:
    """One agent in a tournament; it can be sent to another process, which makes its own instances."""

    name: str
    """Unique in its tournament: `nearest`, and `nearest#2` where it plays against itself."""
    spec: str
    """What `agent_class` finds it by, from any folder."""
    control: Control
    digest: str
    """16 hexadecimal digits of the source file's bytes."""

    def create(self) -> Policy:
        """A fresh instance, for one match."""
        policy: Policy = agent_class(self.spec)()
        return policy


def shipped() -> dict[str, str]:
    """The agents that come with the package: name to one line about each."""
    package = _imported("catch_arena.agents")
    names = sorted(module.name for module in pkgutil.iter_modules(package.__path__))
    return {name: (_imported(f"catch_arena.agents.{name}").__doc__ or "").partition("\n")[0] for name in names}


def enter(specs: Sequence[str]) -> tuple[Entrant, ...]:
    """The entrants that these words stand for, in their order.

    Args: `specs`: shipped names, `package.module:Class`, or paths of .py files with a class `Agent`.
    Raises: AgentError, one line, that names the word and what is wrong with it.
    """
    seen: Counter[str] = Counter()
    entrants = []
    for spec in specs:
        name, whole = _name_and_spec(spec)
        control, digest = _inspected(whole)
        seen[name] += 1
        entrants.append(Entrant(name if seen[name] == 1 else f"{name}#{seen[name]}", whole, control, digest))
    return tuple(entrants)


@cache
def agent_class(spec: str) -> type:
    """The class that a spec stands for. Raises: AgentError."""
    if spec.endswith(".py"):
        module, name = _from_file(Path(spec)), "Agent"
    else:
        place, _, name = spec.partition(":")
        if str(Path.cwd()) not in sys.path and "" not in sys.path:
            sys.path.append(str(Path.cwd()))  # as `python -m` finds modules; workers start in the same folder
        module = _imported(place)
    found = getattr(module, name, None)
    if not isinstance(found, type):
        classes = [key for key, value in vars(module).items() if isinstance(value, type)]
        raise AgentError(f"{spec}: has no class {name}{'; ' + suggest(name, classes) if classes else ''}")
    return found


def _name_and_spec(spec: str) -> tuple[str, str]:
    if spec.endswith(".py"):
        path = Path(spec).expanduser().resolve()
        if not path.is_file():
            raise AgentError(f"{spec}: no such file")
        return path.stem, str(path)
    if ":" in spec:
        return spec.rpartition(":")[2], spec
    known = shipped()
    if spec not in known:
        raise AgentError(
            f"unknown agent {spec!r}: {suggest(spec, known)} (or give package.module:Class, or the path of a .py file)"
        )
    return spec, f"catch_arena.agents.{spec}:Agent"


def _inspected(spec: str) -> tuple[Control, str]:
    """The control and the digest of a class that can play."""
    found = agent_class(spec)
    try:
        policy = found()
    except (Exception, SystemExit) as error:  # a stranger's code may raise anything
        raise AgentError(f"{spec}: {found.__name__}() raised {reason(error)}") from error
    for method in ("reset", "act"):
        if not callable(getattr(policy, method, None)):
            raise AgentError(f"{spec}: {found.__name__} must have a method {method}")
    try:
        control = control_of(policy)
    except CatchArenaError:
        raise AgentError(
            f"{spec}: control must be target, velocity or full, got {getattr(policy, 'control', None)!r}"
        ) from None
    source = getattr(sys.modules.get(found.__module__), "__file__", None)
    content = Path(source).read_bytes() if source else spec.encode()
    return control, hashlib.blake2b(content, digest_size=8).hexdigest()


def _from_file(path: Path) -> ModuleType:
    name = f"catch_arena_agent_{hashlib.blake2b(str(path).encode(), digest_size=8).hexdigest()}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise AgentError(f"{path}: is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:  # a stranger's code may raise anything
        del sys.modules[name]
        raise AgentError(f"{path}: importing it raised {reason(error)}") from error
    return module


def _imported(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except (Exception, SystemExit) as error:  # a stranger's code may raise anything
        raise AgentError(f"{name}: importing it raised {reason(error)}") from error


def reason(error: BaseException) -> str:
    """An exception in one line of at most 200 characters."""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}"[:200] if text else type(error).__name__
