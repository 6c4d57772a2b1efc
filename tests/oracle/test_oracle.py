"""The oracle shares no code with the package and needs the standard library alone."""

import ast
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.mark.parametrize("module", ["arithmetic.py", "arena.py"])
def test_the_oracle_imports_nothing_of_the_package(module: str) -> None:
    """An oracle that shares code shares mistakes."""
    roots = set()
    for node in ast.walk(ast.parse((HERE / module).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            roots |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            roots.add((node.module or "").split(".")[0])
    assert roots
    assert roots <= set(sys.stdlib_module_names) | {"oracle"}
