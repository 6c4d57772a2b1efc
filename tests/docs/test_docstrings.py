"""What ruff does not ask of docstrings: a summary, sections that tools can read, packages that list their modules."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import catch_arena

PACKAGE = Path(catch_arena.__file__).parent
PACKAGES = sorted(path.parent for path in PACKAGE.glob("*/**/__init__.py") if path.parent.name != "agents")
SECTION = r"(Args|Returns|Raises|Yields):"


def docstrings() -> Iterator[tuple[str, str]]:
    """Each docstring of the package, and where it stands."""
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and (said := ast.get_docstring(node)):
                yield f"{path.relative_to(PACKAGE)}: {getattr(node, 'name', 'module')}", said


def test_every_docstring_begins_with_a_summary():
    assert [where for where, said in docstrings() if re.match(SECTION, said)] == []


def test_sections_stand_on_lines_of_their_own():
    """Else no tool finds them."""
    assert [where for where, said in docstrings() if re.search(rf"\b{SECTION}(?!$)", said, re.MULTILINE)] == []


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.name)
def test_a_package_names_all_its_modules(package):
    """In its docstring, which is where readers look for what is in it."""
    said = ast.get_docstring(ast.parse((package / "__init__.py").read_text(encoding="utf-8"))) or ""
    modules = [path.stem for path in package.glob("*.py") if path.stem != "__init__"]
    folders = [path.parent.name for path in package.glob("*/__init__.py")]
    assert [name for name in sorted(modules + folders) if not re.search(rf"\b{name}\b", said)] == []
