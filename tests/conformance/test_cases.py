"""The suite as it stands in the files: what it covers, how much there is, and that it agrees with the rulebook."""

import re
from collections import Counter
from inspect import signature
from itertools import pairwise
from pathlib import Path

import pytest
from conformance.shapes import reach_of, shape
from oracle.arithmetic import SERVICE_LOT, TIE_LOT, draw, key

from catch_arena.arbitration import arbitrate
from catch_arena.conformance.case_files import load_cases, read_cases
from catch_arena.conformance.cases import DEFAULTS, ArbiterCase, ArenaCase
from catch_arena.errors import ConfigError
from catch_arena.verdicts import Verdict

BOOK = (Path(__file__).parents[2] / "docs" / "reference" / "rulebook.md").read_text(encoding="utf-8")
CASES = load_cases()
ARBITER_CASES = [case for case in CASES if isinstance(case, ArbiterCase)]


def test_there_are_at_least_two_hundred_different_cases():
    """Such that differ only by order, label or number count once: 150 for arbiters, 45 for arenas."""
    assert len({shape(case) for case in CASES}) >= 200
    assert len({shape(case) for case in ARBITER_CASES}) >= 150
    assert len({shape(case) for case in CASES if isinstance(case, ArenaCase)}) >= 45


def test_an_id_is_used_once():
    assert [name for name, count in Counter(case.id for case in CASES).items() if count > 1] == []


def test_no_two_cases_are_about_the_same_situation():
    """But where the sentence begins «The same»."""
    situations = Counter(case.situation for case in CASES if not case.situation.startswith("The same"))
    assert [situation for situation, count in situations.items() if count > 1] == []


def test_every_clause_of_chapter_5_has_a_case():
    cited = {clause for case in CASES for clause in case.clauses}
    chapter = re.findall(r"^\*\*(R5\.\d+)\*\*", BOOK, flags=re.MULTILINE)
    assert "R5.1" in chapter
    assert [clause for clause in chapter if clause not in cited] == []


def test_a_case_means_what_arbitrate_means_where_neither_says_otherwise():
    """Two tables: the suite imports no arbiter."""
    arguments = signature(arbitrate).parameters.values()
    assert {one.name: one.default for one in arguments if one.default is not one.empty} == DEFAULTS


def test_every_clause_that_is_cited_is_in_the_book():
    known = set(re.findall(r"^\*\*(R\d+\.\d+)\*\*", BOOK, flags=re.MULTILINE))
    assert sorted({clause for case in CASES for clause in case.clauses} - known) == []


def test_every_verdict_is_expected_somewhere():
    assert {one.verdict for case in ARBITER_CASES for one in case.expected} >= set(Verdict)


def test_each_test_of_the_arbiter_is_met_before_each_later_one():
    """R5.2's order: of two neighbours there is a case in which the first is given and the second would apply too.

    Only UNKNOWN_TARGET and ALREADY_CAUGHT do not meet: no name is both.
    """
    order = [verdict for verdict in Verdict if verdict is not Verdict.GRANTED]
    for earlier, later in pairwise(order):
        if earlier is Verdict.UNKNOWN_TARGET:
            continue
        assert any(
            one.verdict is earlier and later in would_apply(case, place)
            for case in ARBITER_CASES
            for place, one in enumerate(case.expected)
        ), f"{earlier.name} before {later.name}"


def would_apply(case: ArbiterCase, place: int) -> set[Verdict]:
    """The verdicts whose conditions a request meets, whatever is tested before them."""
    one, own = case.expected[place], case.circumstances
    alive = isinstance(one.target, str) and one.target in case.targets
    rivals = [other for other in case.expected if other.target == one.target and other.hunter != one.hunter]
    dx, dy = (
        (a - b for a, b in zip(case.hunters[one.hunter], case.targets[str(one.target)], strict=True))
        if alive
        else (0, 0)
    )
    met = {
        Verdict.MATCH_OVER: own["match_over"],
        Verdict.MALFORMED: not isinstance(one.target, str) or len(one.target) > 255,
        Verdict.HUNTER_INACTIVE: one.hunter in own["inactive"],
        Verdict.DUPLICATE: any(other.hunter == one.hunter for other in case.expected[:place]),
        Verdict.UNKNOWN_TARGET: isinstance(one.target, str) and not alive and one.target not in own["caught"],
        Verdict.ALREADY_CAUGHT: isinstance(one.target, str) and one.target in own["caught"],
        Verdict.SERVICE_DOWN: not own["kill_service_up"],
        Verdict.OUT_OF_REACH: alive and (dx * dx + dy * dy) ** 0.5 > reach_of(case, one),
        Verdict.LOST_CONTEST: alive and bool(rivals),
        Verdict.KILL_FAILED: alive and one.target in own["kill_refused"],
    }
    return {verdict for verdict, applies in met.items() if applies}


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


def test_long_names_are_as_long_as_their_cases_say():
    long = [case for case in ARBITER_CASES if re.match(r"names\.25[56]", case.id)]
    assert len(long) == 6
    for case in long:
        assert len(str(case.expected[0].target)) == int(case.id[6:9])


def test_a_choice_names_the_rulebooks_own_answer_first_and_another():
    chosen = [case for case in CASES if case.options]
    assert len(chosen) >= 20
    assert all(len(set(case.options)) >= 2 for case in chosen)


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
        ("[[case]]", "[[cases]]", "some.toml: may contain only [[case]] and [[arena_case]] tables, got 'cases'"),
        ("[[case]]", "case = 3\n[[arena_case]]", "some.toml: may contain only [[case]] and [[arena_case]] tables"),
        ('id = "some.case"\n', "", "some.toml: case without an id: Object missing required field `id`"),
        ('"some.case"', '"other.case"', "id must be 'some.' and lower-case words"),
        ('"some.case"', '"some.Case"', "got 'some.Case'"),
        ('["R5.4"]', '["5.4"]', "some.toml: some.case: Expected `str` matching regex"),
        ('["R5.4"]', "[]", "Expected `array` of length >= 1 - at `$.clauses`"),
        ('"One asks."', "1", "Expected `str`, got `int` - at `$.situation`"),
        ('why = "It must."', "", "missing required field `why`"),
        ("[[1.0, 1.0],", "[[1.0],", "Expected `array` of length 2, got 1 - at `$.hunters[0]`"),
        ("[[1.0, 1.0],", '[[1.0, "1"],', "Expected `float`, got `str` - at `$.hunters[0][1]`"),
        ("{ a = [1.1, 1.0] }", "{ a = [1.1, nan] }", "at `$.targets[...][1]`"),
        ("requests =", "request =", "unknown field `request`"),
        ("hunter = 0", "hunter = 2", "some.case: hunter must be below 2, their number in the case, got 2"),
        ("hunter = 0", "hunter = true", "Expected `int`, got `bool` - at `$.requests[0].hunter`"),
        ('name = "a", ', "", "missing required field `name` - at `$.requests[0]`"),
        ('"GRANTED"', '"granted"', "verdict must be one of LOT, MATCH_OVER"),
        ('"GRANTED"', '"LOT"', "verdict LOT must be for one of the lot's seats"),
        ("100_000", "0.1", "got `float` - at `$.requests[0].distance_um`"),
        ("winner = 0", "winner = 7", "hunter must be below 2, their number in the case, got 7"),
        ("winner = 0", 'winner = "LOT"', "lots must contain the target of every ruling by lot"),
        ("winner = 0", "wins = 0", "unknown field `wins`"),
        (
            "requests =",
            "under_nearest = [{ hunter = 1, name = 'a', verdict = 'GRANTED' }]\nrequests =",
            "under_nearest must have one ruling for each request of the case, in their order",
        ),
        ("requests =", 'policy = "farthest"\nrequests =', "Invalid enum value 'farthest' - at `$.policy`"),
        ("requests =", 'inactive = ["hunter_0"]\nrequests =', "Expected `int`, got `str` - at `$.inactive[0]`"),
        ("requests =", "match_over = 1\nrequests =", "Expected `bool`, got `int` - at `$.match_over`"),
        ("requests =", "reach_m = [0.3]\nrequests =", "reach_m must be one number, or one for each of the 2 hunters"),
        ("requests =", "fair_over_steps = 9\nrequests =", "fair_over_steps needs lots: add them, or remove it"),
        (
            "requests =",
            "lots = [{ target = 'b', seats = [0], drawn = 0 }]\nrequests =",
            "lots must be for alive targets",
        ),
        ("requests =", "lots = [{ target = 'a', seats = [0], drawn = 1 }]\nrequests =", "drawn must be one of"),
        ("{ hunters = 1 }", "{ hunter = 1 }", "some.toml: some.play: Object contains unknown field `hunter`"),
        ("{ hunters = 1 }", '{ hunters = "two" }', "Expected `int`, got `str` - at `$.settings.hunters`"),
        ("steps = 1", "step = 1", "unknown field `step`"),
        ("time_ms = 100", "time = 100", "Invalid enum value 'time'"),
        (
            "steps = 1",
            "requests = [{ hunter = 1, number = 1, verdict = 'GRANTED' }]",
            "hunter must be below 1, their number in the case, got 1",
        ),
        ("steps = 1", "drive = [[0, 1.0]]", "Expected `array` of length 3, got 2 - at `$.play[0].drive[0]`"),
        ("steps = 1", "hunters = [[1.0, 1.0]]", "Expected `array` of length 3, got 2 - at `$.play[0].hunters[0]`"),
        ("steps = 1", "withdraw_prey = 0", "prey must be below 0, their number in the case, got 0"),
        ("steps = 1", "drive_prey = [[0, 1.0, 0.0]]", "prey must be below 0, their number in the case, got 0"),
        ("{ hunters = 1 }", "{ prey = 1, prey_returns_s = 'ALWAYS' }", "at `$.settings.prey_returns_s`"),
        ("{ hunters = 1 }", "{ teams = [0] }", "Expected `array`, got `int` - at `$.settings.teams[0]`"),
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
