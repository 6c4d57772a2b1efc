"""The book, the tests and the code name the same clauses."""

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
BOOK = ROOT / "docs" / "rulebook.md"
PACKAGE = ROOT / "catch_arena"


@cache
def clauses() -> list[str]:
    """The clauses that the book defines, in its order."""
    return re.findall(r"^\*\*(R\d+\.\d+)\*\*", BOOK.read_text(encoding="utf-8"), flags=re.MULTILINE)


@cache
def marks() -> set[str]:
    """The clauses that tests are marked with."""
    calls = [
        node
        for path in ROOT.glob("tests/**/test_*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "pytest.mark.rule"
    ]
    return {ast.literal_eval(clause) for call in calls for clause in call.args}


def test_every_clause_has_a_test() -> None:
    """With its mark."""
    assert [clause for clause in clauses() if clause not in marks()] == []


def test_every_mark_names_a_clause() -> None:
    """A mark that was mistyped would prove nothing."""
    assert sorted(marks() - set(clauses())) == []


def test_every_clause_is_cited_in_the_code() -> None:
    """Somewhere in the package, so that it can be found by its number."""
    cited: set[str] = set()
    for path in PACKAGE.rglob("*.py"):
        cited |= set(re.findall(r"R\d+\.\d+", path.read_text(encoding="utf-8")))
    assert [clause for clause in clauses() if clause not in cited] == []


def test_the_code_cites_no_clause_that_the_book_does_not_have() -> None:
    """A number that was mistyped would lead nowhere."""
    known = set(clauses())
    for path in (*PACKAGE.rglob("*.py"), *ROOT.glob("tests/**/*.py")):
        cited = set(re.findall(r"\bR\d+\.\d+\b", path.read_text(encoding="utf-8")))
        assert sorted(cited - known) == [], path
