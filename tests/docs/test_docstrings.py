"""Docstrings that an editor shows alone: a summary in plain words, readable sections, packages that list modules."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import catch_arena

PACKAGE = Path(catch_arena.__file__).parent
PACKAGES = sorted(path.parent for path in PACKAGE.glob("*/**/__init__.py") if path.parent.name != "agents")
SECTION = r"(Args|Returns|Raises|Yields):"
CLAUSES = re.compile(r"^([RA]\d*\.\d+('s)?(, | to | and |: ))+")
"""Clause numbers, which may stand before a summary."""
NO_BEGINNING = re.compile(
    r"(What|Of|How|Whether|Where|Who|Whose|That|Those|It|Its|This|These|And|As|Likewise|The same)\b", re.IGNORECASE
)
"""First words of sentences that cannot be understood alone."""
NOT_PLAIN = re.compile(r"\b(told|tells|untold|anew|nobody|somebody|whoever|so many|likewise)\b", re.IGNORECASE)


def docstrings() -> Iterator[tuple[str, str]]:
    """Each docstring of the package, and where it stands."""
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and (said := ast.get_docstring(node)):
                yield f"{path.relative_to(PACKAGE)}: {getattr(node, 'name', 'module')}", said


def texts() -> Iterator[tuple[str, str]]:
    """Yield the docstrings of the package, of attributes too, each with its place."""
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            match node:
                case ast.Expr(value=ast.Constant(value=str(text))):
                    yield f"{path.relative_to(PACKAGE)}:{node.lineno}", text.strip()


def test_every_docstring_can_be_read_alone():
    assert [where for where, text in texts() if NO_BEGINNING.match(CLAUSES.sub("", text))] == []


def test_docstrings_have_no_words_that_have_a_plainer_one():
    assert [where for where, text in texts() if NOT_PLAIN.search(text)] == []


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
