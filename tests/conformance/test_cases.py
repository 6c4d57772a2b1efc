"""The cases cover the arbiter and cite the rulebook; a file with a wrong case is refused in one line."""

import re
from collections import Counter
from inspect import signature
from pathlib import Path

import pytest

from catch_arena.arbitration import arbitrate
from catch_arena.conformance.cases import DEFAULTS, ArbiterCase, load_cases
from catch_arena.errors import ConfigError
from catch_arena.verdicts import Verdict

ROOT = Path(__file__).parents[2]
BOOK = (ROOT / "docs" / "reference" / "rulebook.md").read_text(encoding="utf-8")
CASES = load_cases()
ARBITER_CASES = [case for case in CASES if isinstance(case, ArbiterCase)]


def test_there_are_as_many_cases_as_the_page_says_and_an_id_is_used_once():
    assert len(CASES) > 200
    assert [name for name, count in Counter(case.id for case in CASES).items() if count > 1] == []


def test_every_clause_of_chapter_5_has_a_case():
    cited = {clause for case in CASES for clause in case.clauses}
    chapter = re.findall(r"^### (R5\.\d+) ", BOOK, flags=re.MULTILINE)
    assert "R5.1" in chapter
    assert [clause for clause in chapter if clause not in cited] == []


def test_a_case_means_what_arbitrate_means_where_neither_says_otherwise():
    """Two tables: the suite imports no arbiter."""
    arguments = signature(arbitrate).parameters.values()
    assert {one.name: one.default for one in arguments if one.default is not one.empty} == DEFAULTS


def test_every_verdict_is_expected_somewhere():
    assert {one.verdict for case in ARBITER_CASES for one in case.expected} >= set(Verdict)


GOOD = """
[[case]]
id = "some.case"
clauses = ["R5.4"]
situation = "One asks."
why = "It must."
hunters = [[1.0, 1.0]]
targets = { a = [1.1, 1.0] }
requests = [{ hunter = 0, name = "a", verdict = "GRANTED", distance_um = 100_000, winner = 0 }]
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[[case]]", "[[case]", "some.toml: "),
        ("[[case]]", "[[cases]]", "some.toml: Object contains unknown field `cases`"),
        ('why = "It must."', "", "some.toml: Object missing required field `why` - at `$.case[0]`"),
        ('"GRANTED"', '"granted"', "some.toml: Expected `str` matching regex '^(LOT|MATCH_OVER|"),
    ],
)
def test_a_file_that_is_wrong_is_named_in_one_line(monkeypatch, tmp_path, old, new, message):
    (tmp_path / "cases").mkdir()
    (tmp_path / "cases" / "some.toml").write_text(GOOD.replace(old, new))
    monkeypatch.setattr("catch_arena.conformance.cases.files", lambda _: tmp_path)
    with pytest.raises(ConfigError, match=f"^{re.escape(message)}.*$"):
        load_cases.__wrapped__()
