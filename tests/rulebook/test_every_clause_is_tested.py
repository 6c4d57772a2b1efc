"""The book, the tests and the code name the same clauses."""

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
BOOK = ROOT / "docs" / "reference" / "rulebook.md"
APPENDIX = ROOT / "docs" / "reference" / "bit_exact.md"
PACKAGE = ROOT / "catch_arena"


@cache
def clauses() -> list[str]:
    """The clauses that the book defines, in its order: each has a heading, so that one can link to it."""
    return re.findall(r"^### (R\d+\.\d+) \w", BOOK.read_text(encoding="utf-8"), flags=re.MULTILINE)


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


def test_the_code_and_the_book_cite_no_section_that_the_appendix_does_not_have() -> None:
    """Sections are A.1, A.2 and so on; A.7 has subsections."""
    section = r"\bA\.\d+(?:\.\d+)?\b"
    known = set(re.findall(rf"^###? ({section}) \w", APPENDIX.read_text(encoding="utf-8"), flags=re.MULTILINE))
    for path in (BOOK, APPENDIX, *PACKAGE.rglob("*.py"), *ROOT.glob("tests/**/*.py")):
        cited = set(re.findall(section, path.read_text(encoding="utf-8")))
        assert sorted(cited - known) == [], path
