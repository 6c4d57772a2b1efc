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
def marks() -> dict[str, list[str]]:
    """The tests that bear each clause's mark."""
    found: dict[str, list[str]] = {}
    for path in sorted(ROOT.glob("tests/**/test_*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.FunctionDef) or not node.name.startswith("test_"):
                continue
            for decorator in node.decorator_list:
                if isinstance(decorator, ast.Call) and ast.unparse(decorator.func) == "pytest.mark.rule":
                    for clause in decorator.args:
                        found.setdefault(ast.literal_eval(clause), []).append(node.name)
    return found


def test_the_books_clauses_are_numbered_without_gaps() -> None:
    """Twelve chapters, each counted from 1; no number twice."""
    numbers = [tuple(map(int, clause[1:].split("."))) for clause in clauses()]
    assert numbers == sorted(set(numbers))
    chapters = sorted({chapter for chapter, _ in numbers})
    assert chapters == list(range(1, 13))
    for chapter in chapters:
        counted = [clause for of, clause in numbers if of == chapter]
        assert counted == list(range(1, len(counted) + 1))


def test_every_clause_has_a_test() -> None:
    """With its mark."""
    assert [clause for clause in clauses() if clause not in marks()] == []


def test_every_mark_names_a_clause() -> None:
    """Of the book."""
    assert sorted(set(marks()) - set(clauses())) == []


def test_a_tests_name_begins_with_a_clause_that_it_is_marked_with() -> None:
    """So that a failure says at once which clause is broken."""
    of_name: dict[str, set[str]] = {}
    for clause, names in marks().items():
        for name in names:
            of_name.setdefault(name, set()).add(clause)
    for name, bears in of_name.items():
        match = re.match(r"test_r(\d+)_(\d+)_", name)
        assert match, name
        assert f"R{match[1]}.{match[2]}" in bears, name


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
