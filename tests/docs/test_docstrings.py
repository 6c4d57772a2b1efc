"""Plain words in all texts, docstrings that an editor shows alone, and packages that name all their modules."""

import ast
import re
from pathlib import Path

import pytest

import catch_arena

PACKAGE = Path(catch_arena.__file__).parent
ROOT = PACKAGE.parent
PACKAGES = sorted(path.parent for path in PACKAGE.glob("*/**/__init__.py") if path.parent.name != "agents")
CLAUSES = re.compile(r"^([RA]\d*\.\d+('s)?(, | to | and |: ))+")
"""Clause numbers, which may stand before a summary."""
FIRST_WORDS = "What|Of|How|Whether|Where|Who|Whose|That|Those|It|Its|This|These|And|As|Likewise|The same"
NO_BEGINNING = re.compile(rf"({FIRST_WORDS})\b|(Args|Returns|Raises|Yields):", re.IGNORECASE)
"""Beginnings of docstrings that cannot be understood alone."""
NOT_PLAIN = re.compile(r"\b(told|tells|untold|anew|nobody|somebody|whoever|so many|likewise)\b", re.IGNORECASE)
"""Words that have a plainer one."""
TEXTS = ("agents", "catch_arena", "docs", "examples", "ros2", "scripts", "CONTRIBUTING.md", "Makefile", "README.md")


@pytest.mark.parametrize("name", TEXTS)
def test_texts_have_no_words_that_have_a_plainer_one(name):
    endings = {"", ".c", ".css", ".html", ".js", ".md", ".py", ".svg", ".toml"}
    paths = [path for path in (ROOT / name, *(ROOT / name).rglob("*")) if path.is_file() and path.suffix in endings]
    found = [(str(path), word[0]) for path in paths for word in NOT_PLAIN.finditer(path.read_text(encoding="utf-8"))]
    assert (bool(paths), found) == (True, [])


def test_every_docstring_can_be_read_alone_and_has_its_sections_on_lines_of_their_own():
    """Docstrings of attributes are read too."""
    docstrings = {
        f"{path.relative_to(PACKAGE)}:{node.lineno}": node.value.value.strip()
        for path in sorted(PACKAGE.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    }
    assert [place for place, text in docstrings.items() if NO_BEGINNING.match(CLAUSES.sub("", text))] == []
    section = re.compile(r"\b(Args|Returns|Raises|Yields):(?!$)", re.MULTILINE)
    assert [place for place, text in docstrings.items() if section.search(text)] == []


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.name)
def test_a_package_names_all_its_modules(package):
    """In its docstring, which is where readers look for what is in it."""
    text = ast.get_docstring(ast.parse((package / "__init__.py").read_text(encoding="utf-8"))) or ""
    modules = [path.stem for path in package.glob("*.py") if path.stem != "__init__"]
    folders = [path.parent.name for path in package.glob("*/__init__.py")]
    assert [name for name in sorted(modules + folders) if not re.search(rf"\b{name}\b", text)] == []
