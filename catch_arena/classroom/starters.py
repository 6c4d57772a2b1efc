"""Files that `new-agent` and `new-class` write: an agent to begin with, and a class to try the grading with."""

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path

from catch_arena.errors import OutputError
from catch_arena.files import prepare_folder, write_whole

_SPEC = "exercise.toml"
_PROGRAMS = ("agent.py", "test_agent.py")


def write_agent_kit(folder: Path) -> list[Path]:
    """Write an agent with its test, a spec and a workflow file for continuous integration, and return the files."""
    kit = {name: _content("kit", name) for name in _PROGRAMS}
    kit["README.md"] = _content("kit", "README.md").replace("NAME", folder.absolute().name, 1)
    return _write(
        folder, {**kit, _SPEC: _content("sample", _SPEC), ".github/workflows/grade.yml": _content("kit", "grade.yml")}
    )


def kit_programs() -> list[bytes]:
    """Return the programs that `new-agent` writes: the agent and its test."""
    return [_content("kit", name).encode() for name in _PROGRAMS]


def write_sample_class(folder: Path) -> list[Path]:
    """Write a spec and five submissions, and return the files: a good one, its copy, and three with common mistakes."""
    names = sorted(one.name for one in (files(__package__) / "sample").iterdir() if one.name.endswith(".py"))
    submissions = {f"submissions/{name}": _content("sample", name) for name in names}
    return _write(folder, {_SPEC: _content("sample", _SPEC), **submissions})


def _write(folder: Path, contents: Mapping[str, str]) -> list[Path]:
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise OutputError(f"{folder}: already exists; choose the name of a new or an empty folder")
    for name, content in contents.items():
        path = folder / name
        prepare_folder(path.parent)
        write_whole(path, content.encode())
    return [folder / name for name in contents]


def _content(folder: str, name: str) -> str:
    return (files(__package__ or "") / folder / name).read_text(encoding="utf-8")
