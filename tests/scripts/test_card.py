"""`make card`: the page says what was measured, of all agents that come with the package."""

import math
import re
import runpy
from pathlib import Path

from catch_arena.suite.contents import SUITE
from catch_arena.suite.measures import AgentMeasures, ScenarioMeasures
from catch_arena.tournament.entrants import enter, shipped
from catch_arena.tournament.statistics.intervals import Estimate

ROOT = Path(__file__).parents[2]
CARD = runpy.run_path(str(ROOT / "scripts" / "card.py"))


def reached(name, scores, blocks=4, forfeits=0):
    """An agent with these scores in the first scenarios, and 0.6 in all others."""
    (agent,) = enter([name])
    scenarios = []
    for place, one in enumerate(SUITE.scenarios):
        score = scores[place] if place < len(scores) else 0.6
        estimate = Estimate(score, score - 0.01, score + 0.01)
        codes = {"FORFEIT_CRASH": forfeits} if forfeits and not place else {}
        scenarios.append(
            ScenarioMeasures(
                name=one.name,
                held_out=one.held_out,
                by_block=(score,) * blocks,
                score=estimate,
                win_share=estimate,
                place=1,
                of=6,
                first_group=score > 0.5,
                matches=8,
                forfeits=codes,
                move_ms=0.25,
            )
        )
    return AgentMeasures(agent, blocks, tuple(scenarios))


def test_the_page_says_what_was_measured():
    whole = SUITE.blocks
    measured = [reached("patrol", [0.3, 0.7, 0.2], whole), reached("idle", [0.0] * len(SUITE.scenarios))]
    page = CARD["page"](measured, whole)
    assert SUITE.digest in page
    (row,) = re.findall(r"^\| \[`patrol`\]\(#patrol\) \| velocity \| 10 \| .* \|$", page, re.MULTILINE)
    assert "12 of 14" in row
    assert "of 14" not in re.search(r"^\| \[`idle`\].*", page, re.MULTILINE)[0]  # few blocks: nobody can be told apart
    assert "0.25 ms" in row
    assert "- Not good at: `scarce` (a target every two seconds), 0.20; `standard` (four hunters" in page
    assert "- Not good at: any scenario" in page
    assert f"- Matches: {8 * len(SUITE.scenarios)}, of which it forfeited 0." in page
    assert shipped()["patrol"] in page
    assert "It is a training opponent of the suite, and meets itself there." in page


def test_a_scenario_with_forfeits_is_a_weakness():
    page = CARD["page"]([reached("patrol", [0.9], forfeits=3)], 4)
    assert "- Not good at: `standard` (four hunters in turtlesim's arena), 0.90." in page
    assert "of which it forfeited 3." in page


def test_where_few_blocks_were_played_no_interval_is_given():
    one = reached("patrol", [], blocks=2)
    assert math.isnan(one.training.low)
    assert CARD["figure"](one.training) == "0.60 (?)"


def test_the_card_in_the_docs_is_of_this_suite_and_has_every_shipped_agent():
    """If this fails: `make card`."""
    page = (ROOT / "docs" / "card.md").read_text()
    assert SUITE.digest in page
    assert set(re.findall(r"^### (\w+)$", page, re.MULTILINE)) == set(shipped())
