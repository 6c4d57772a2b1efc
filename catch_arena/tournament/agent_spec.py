"""Specs of agents: from a word on the command line to an agent's spec, name and digest.

A spec is the absolute path of a .py file or of a folder with an agent.py, `package.module:Class`, or `cmd:` and a
command with absolute paths.
"""

import hashlib
import os
import pkgutil
import shlex
import shutil
from codecs import BOM_UTF8
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final, NamedTuple

from catch_arena import agents
from catch_arena.errors import AgentError, suggest
from catch_arena.text import composed

COMMAND: Final = "cmd:"
SHIPPED: Final = "catch_arena.agents"
LADDER: Final = "ladder."
"""Prefix of the names of frozen learned agents, which are in the package `catch_arena.agents.ladder`."""
IN_FOLDER: Final = "agent.py"
"""Name of the file with the class `Agent`, if an agent is a folder."""
TEMPORARY: Final = Path("/tmp")  # noqa: S108
"""Folder of temporary files; an agent in namespaces has one of its own in its place."""
_ELSE: Final = f"a .py file, a folder with {IN_FOLDER}, package.module:Class, or {COMMAND}COMMAND"
_WEIGHTS: Final = (".npz", ".npy", ".safetensors", ".onnx", ".pt", ".pth")
_LARGEST_SOURCE: Final = 1 << 26
"""Largest part of a file that is read [bytes]."""
_MOST_SOURCES: Final = 3
"""Largest number of files of an agent: the file of its module, and the files of its two classes."""
_GENERIC: Final = frozenset({"agent", "bot", "main", "player", "solution", "submission"})
"""File names that are too common to name an agent: the folder's name is put before them."""


class AgentSpec(NamedTuple):
    """Agent that a word on the command line names; it has not been loaded."""

    spec: str
    path: tuple[str, ...]
    """Parts of the agent's path: the folders or packages that hold it, then its own name."""
    content: bytes | None = None
    """Bytes for the digest that are known without loading the agent; None if there are none."""

    def digest(self, sources: Sequence[str]) -> str:
        """Return the digest of the agent's files, in 16 hexadecimal digits; of its spec if no file can be read.

        `sources` are its files by its own account; they are ignored for a command and a folder.
        """
        found = [] if self.content is None else [self.content]
        if not self.spec.startswith(COMMAND) and folder_of(self.spec) is None:
            for source in sources[:_MOST_SOURCES]:
                content = content_of(source)
                if content is not None and source != self.spec:
                    found.append(content + _weights_beside(Path(source)))
        return hashlib.blake2b(b"\0".join(found or [self.spec.encode()]), digest_size=8).hexdigest()


def shipped_spec(name: str) -> str:
    """Return the spec of an agent that comes with the package."""
    return f"{SHIPPED}.{name}:Agent"


def shipped_names() -> list[str]:
    """Return the names of the agents that come with the package, without frozen learned ones."""
    return sorted(module.name for module in pkgutil.iter_modules(agents.__path__) if not module.ispkg)


def ladder_names() -> list[str]:
    """Return the names of the frozen learned agents that come with the package, such as `ladder.tag_prey_1_400k`."""
    folders = [str(Path(folder) / "ladder") for folder in agents.__path__]
    return sorted(module.name for module in pkgutil.iter_modules(folders, LADDER))


def is_shipped(spec: str) -> bool:
    """Return whether an agent comes with the package; such an agent is trusted, and plays in this process."""
    return spec.startswith(f"{SHIPPED}.")


def folder_of(spec: str) -> Path | None:
    """Return the folder of an agent that is a folder with an agent.py; None for all others."""
    return Path(spec) if Path(spec).is_absolute() and not spec.endswith(".py") else None


def file_of(spec: str) -> Path | None:
    """Return the file with the class of an agent in a file or folder; None for modules and commands."""
    folder = folder_of(spec)
    return folder / IN_FOLDER if folder is not None else Path(spec) if spec.endswith(".py") else None


def command_of(spec: str) -> list[str] | None:
    """Return the words of a command, its program first; None for an agent in Python."""
    return shlex.split(spec.removeprefix(COMMAND)) if spec.startswith(COMMAND) else None


def resolve(word: str) -> AgentSpec:
    """Return the agent that a word on the command line names, or raise AgentError."""
    if not word:
        raise AgentError("an agent must be a name, a file, a folder or a command, got ''")
    if word.startswith(COMMAND):
        return _resolve_command(word)
    if (file := word.rpartition(":")[0]).endswith(".py"):
        raise AgentError(f"{word}: a file is given alone, and its class is called Agent: {file}")
    path = _absolute(word)
    exists, is_path = os.path.lexists(path), os.sep in word or word.endswith(".py")
    if word in (known := ladder_names() if word.startswith(LADDER) else shipped_names()):
        return AgentSpec(shipped_spec(word), (word,))
    if not exists and ":" not in word and path.with_suffix(".py").is_file():
        raise AgentError(f"{word}: no such file; a file is given with its ending, as {Path(word).with_suffix('.py')}")
    if is_path or exists:
        return _resolve_path(word, path)
    if ":" in word:
        return AgentSpec(word, tuple(word.replace(":", ".").split(".")))
    if path.suffix and not word.startswith(LADDER):
        raise AgentError(f"{word}: no such file; give a shipped agent's name, {_ELSE}")
    raise AgentError(f"unknown agent {word!r}: {suggest(word, known)} (or give {_ELSE})")


def unique_names(found: Sequence[AgentSpec]) -> list[str]:
    """Return a unique name for each agent: the last part of its path, with as many parts before it as are needed.

    The second agent with the same path is `name#2`.
    """
    depths = {one.path: 2 if one.path[-1] in _GENERIC else 1 for one in found}

    def name(path: tuple[str, ...]) -> str:
        return "/".join(path[-depths[path] :])

    for _ in range(max(map(len, depths), default=0)):
        often = Counter(map(name, depths))
        for path in [path for path in depths if often[name(path)] > 1]:
            depths[path] += 1
    seen: Counter[str] = Counter()
    names: list[str] = []
    for wanted in (name(one.path) for one in found):
        seen[wanted] += 1
        while (unique := wanted if seen[wanted] == 1 else f"{wanted}#{seen[wanted]}") in names:
            seen[wanted] += 1  # a file may have the name `name#2`
        names.append(unique)
    return names


def content_of(source: str) -> bytes | None:
    """Return the content of a file that an agent names as its own; None if it is no regular file or unreadable."""
    try:
        if not Path(source).is_file():  # to open a pipe without a writer would block
            return None
        with Path(source).open("rb") as file:
            return file.read(_LARGEST_SOURCE)
    except (OSError, ValueError):
        return None


def digest_of_files(files: Iterable[tuple[str | Path, Path]], size: int) -> "hashlib.blake2b":
    """Return a digest, of `size` bytes, of the names and contents of files, which are given with their names."""
    digest = hashlib.blake2b(digest_size=size)
    for name, path in files:  # they may hold more than memory does
        digest.update(os.fsencode(name) + b"\0" + (content_of(str(path)) or b"") + b"\0")
    return digest


def _resolve_path(word: str, path: Path) -> AgentSpec:
    if path.is_dir():
        if path.suffix == ".py":
            raise AgentError(f"{word}: is a folder, and its name must not end in .py")
        if TEMPORARY.is_relative_to(path):
            why = "holds all temporary files, and an agent sees its whole folder"
            raise AgentError(f"{word}: {why}: move {IN_FOLDER} into a folder of its own")
        if not (path / IN_FOLDER).is_file():
            raise AgentError(f"{word}: is a folder without {IN_FOLDER}, which holds the class Agent")
        if (path / IN_FOLDER).is_symlink():
            raise AgentError(f"{word}: its {IN_FOLDER} is a link, and an isolated agent sees only its folder: copy it")
        return AgentSpec(str(path), tuple(map(composed, path.parts[1:])), _digest_of_folder(path))
    if not path.is_file():
        other = "is no regular file" if path.exists() else "no such file"
        raise AgentError(f"{word}: {'is a link that leads to no file' if path.is_symlink() else other}")
    content = path.read_bytes()
    if path.suffix == ".ipynb" or (content.lstrip().startswith(b"{") and b'"cells"' in content):
        raise AgentError(f"{word}: is a notebook; save the code of its agent as a .py file with a class Agent")
    if path.suffix != ".py":
        right = path.with_suffix(".py").name
        hint = f"rename it to {right}" if path.suffix.lower() == ".py" else "other programs are given as cmd:COMMAND"
        raise AgentError(f"{word}: must be a .py file or a folder with {IN_FOLDER}; {hint}")
    return AgentSpec(str(path), _path_to(path), content + _weights_beside(path))


def _resolve_command(spec: str) -> AgentSpec:
    """Return the spec of a command; its files get absolute paths, since it is started in another folder."""
    try:
        words = shlex.split(spec.removeprefix(COMMAND))
    except ValueError as error:
        raise AgentError(f"{spec}: must be a command as a shell takes it: {error}") from None
    if not words:
        raise AgentError(f"{COMMAND} must name a command, as in {COMMAND}./my_bot")
    # as the kernel reads the word: in s/../b nothing is there, unless s is a folder
    named = {word: _absolute(word) for word in words if os.path.exists(os.path.expanduser(word))}  # noqa: PTH110
    files = {word: path for word, path in named.items() if path.is_file()}
    program, *arguments = [str(named.get(word, word)) for word in words]
    if words[0] in files:
        _require_program(words[0], files[words[0]])
    found = shutil.which(program)
    if found is None:
        is_path = os.sep in program
        why = "is no program" if words[0] in named else "no such file" if is_path else "is not found in PATH"
        raise AgentError(f"{words[0]}: {why}")
    contents = (_digest_of_folder(path) if path.is_dir() else path.read_bytes() for path in named.values())
    content = b"\0".join([*(word.encode() for word in words if word not in named), *contents])
    path = next(iter(files.values()), Path(Path(program).name))
    return AgentSpec(COMMAND + shlex.join([found, *arguments]), _path_to(path), content)


def _absolute(word: str) -> Path:
    """Return the absolute path of a word; links stay, and so does the tilde of an unknown user."""
    return Path(os.path.abspath(os.path.expanduser(word)))  # noqa: PTH100 - Path.absolute() keeps ".."


def _require_program(word: str, path: Path) -> None:
    """Raise AgentError unless a file is executable, and its first line names an installed interpreter, or none.

    A byte order mark in front of such a line is refused too.
    """
    if not os.access(path, os.X_OK):
        raise AgentError(f"{word}: must be executable: chmod +x {word}")
    first = (content_of(str(path)) or b"").partition(b"\n")[0]
    if first.startswith(BOM_UTF8 + b"#!"):
        raise AgentError(
            f"{word}: begins with a byte order mark, which hides its #!: sed -i '1s/^\\xef\\xbb\\xbf//' {word}"
        )
    if not first.startswith(b"#!"):
        return
    if first.endswith(b"\r"):
        raise AgentError(f"{word}: its lines end as on Windows (CR LF): sed -i 's/\\r$//' {word}")
    interpreter, *options = os.fsdecode(first[2:]).split() or [""]
    needed = options[-1] if Path(interpreter).name == "env" and len(options) == 1 else interpreter
    if shutil.which(needed) is None:
        raise AgentError(f"{word}: its first line names the interpreter {needed!r}, which is not installed here")


def _path_to(file: Path) -> tuple[str, ...]:
    """Return the folders and the stem of a file; the `__init__.py` of a package gets the folder's name."""
    parts = file.parts[1:-1]
    if file.name != "__init__.py" or not parts:
        parts = (*parts, file.stem)
    return tuple(map(composed, parts))


def _digest_of_folder(folder: Path) -> bytes:
    """Return a digest of the names and contents of a folder's files, without `__pycache__` and hidden files."""
    paths = ((path.relative_to(folder), path) for path in sorted(folder.rglob("*")))
    kept = (one for one in paths if not any(part[0] == "." or part == "__pycache__" for part in one[0].parts))
    return digest_of_files(kept, 64).digest()


def _weights_beside(path: Path) -> bytes:
    """Return the weights of a network, from files with the agent's stem next to it: `mine.npz` for `mine.py`."""
    return b"".join(content_of(str(path.with_suffix(suffix))) or b"" for suffix in _WEIGHTS)
