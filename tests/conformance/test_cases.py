"""The cases cover the arbiter and cite the rulebook; a file with a wrong case is refused in one line."""

import re
from collections import Counter
from inspect import signature
from pathlib import Path

import pytest
from oracle.arithmetic import SERVICE_LOT, TIE_LOT, draw, key

from catch_arena.arbitration import arbitrate
from catch_arena.conformance.case_files import load_cases, read_cases
from catch_arena.conformance.cases import DEFAULTS, ArbiterCase, ArenaCase
from catch_arena.errors import ConfigError
from catch_arena.verdicts import Verdict

BOOK = (Path(__file__).parents[2] / "docs" / "reference" / "rulebook.md").read_text(encoding="utf-8")
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


def test_the_lots_are_drawn_as_the_appendix_says():
    """A.5: the lowest lot for the target under `nearest`, the lowest lot of the step under `first_come`."""
    lots = 0
    for case in ARBITER_CASES:
        seed, step = case.circumstances["seed"], case.circumstances["step"]
        for lot in case.lots:
            number = list(case.targets).index(str(lot.target)) + 1
            words = draw(draw(key(seed, TIE_LOT), step), number)
            if case.circumstances["policy"] == "first_come":
                words = draw(key(seed, SERVICE_LOT), step)
            assert lot.drawn == min(lot.seats, key=lambda seat, words=words: draw(words, seat)), case.id
            lots += 1
    assert lots > 20


# ---- files that are wrong ----

GOOD = """
[[case]]
id = "some.case"
clauses = ["R5.4"]
situation = "One asks."
why = "It must."
hunters = [[1.0, 1.0], [1.2, 1.0]]
targets = { a = [1.1, 1.0] }
requests = [{ hunter = 0, name = "a", verdict = "GRANTED", distance_um = 100_000, winner = 0 }]
"""
GOOD_WORLD = """
[[arena_case]]
id = "some.play"
clauses = ["R3.1"]
situation = "Nothing happens."
why = "It must."
settings = { hunters = 1 }
play = [{ steps = 1, read = { time_ms = 100 } }]
"""


def test_a_file_is_read():
    case, play = read_cases("some.toml", GOOD + GOOD_WORLD)
    assert (case.id, case.group) == ("some.case", "some")
    assert isinstance(play, ArenaCase)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[[case]]", "[[case]", "some.toml: is not valid TOML: "),
        ("[[case]]", "[[cases]]", "some.toml: 'cases' is not a [[case]] or [[arena_case]] table"),
        ("[[case]]", "[case]", "some.toml: 'case' is not a [[case]] or [[arena_case]] table, with double brackets"),
        ('id = "some.case"\n', "", "some.toml: case without an id: Object missing required field `id`"),
        ('"some.case"', '"other.case"', "id must look like 'some.lower-case-words', got 'other.case'"),
        ('["R5.4"]', '["5.4"]', "some.toml: some.case: Expected `str` matching regex"),
        ('why = "It must."', "", "missing required field `why`"),
        ("[[1.0, 1.0],", "[[1.0],", "Expected `array` of length 2, got 1 - at `$.hunters[0]`"),
        ("{ a = [1.1, 1.0] }", "{ a = [1.1, nan] }", "at `$.targets[...][1]`"),
        ("requests =", "request =", "unknown field `request`"),
        ("hunter = 0", "hunter = 2", "some.case: hunter must be below 2, their number in the case, got 2"),
        ('"GRANTED"', '"granted"', "verdict must be one of LOT, MATCH_OVER"),
        ('"GRANTED"', '"LOT"', "verdict LOT must be for one of the lot's seats"),
        ("winner = 0", "winner = 7", "hunter must be below 2, their number in the case, got 7"),
        ("winner = 0", 'winner = "LOT"', "lots must contain the target of every ruling by lot"),
        (
            "requests =",
            "under_nearest = [{ hunter = 1, name = 'a', verdict = 'GRANTED' }]\nrequests =",
            "under_nearest must have one ruling for each request of the case, in their order",
        ),
        ("requests =", 'policy = "farthest"\nrequests =', "Invalid enum value 'farthest' - at `$.policy`"),
        ("requests =", "reach_m = [0.3]\nrequests =", "reach_m must be one number, or one for each of the 2 hunters"),
        ("requests =", "fair_over_steps = 9\nrequests =", "fair_over_steps needs lots: add them, or remove it"),
        (
            "requests =",
            "lots = [{ target = 'b', seats = [0], drawn = 0 }]\nrequests =",
            "lots must be for alive targets",
        ),
        ("requests =", "lots = [{ target = 'a', seats = [0], drawn = 1 }]\nrequests =", "drawn must be one of"),
        ("{ hunters = 1 }", "{ hunter = 1 }", "some.toml: some.play: Object contains unknown field `hunter`"),
        ("time_ms = 100", "time = 100", "Invalid enum value 'time'"),
        (
            "steps = 1",
            "requests = [{ hunter = 1, number = 1, verdict = 'GRANTED' }]",
            "hunter must be below 1, their number in the case, got 1",
        ),
        ("steps = 1", "hunters = [[1.0, 1.0]]", "Expected `array` of length 3, got 2 - at `$.play[0].hunters[0]`"),
        ("steps = 1", "withdraw_prey = 0", "prey must be below 0, their number in the case, got 0"),
        ("{ hunters = 1 }", "{ teams = [[1]] }", "hunter must be below 1, their number in the case, got 1"),
        ('"some.play"', '"some.case"', "some.case: id must be unique"),
    ],
)
def test_a_file_that_is_wrong_is_refused_in_one_line(old: str, new: str, message: str):
    """Which names the file, the case and the field."""
    text = GOOD + GOOD_WORLD
    assert old in text
    with pytest.raises(ConfigError, match=re.escape(message)) as error:
        read_cases("some.toml", text.replace(old, new, 1))
    assert "\n" not in str(error.value)
