"""`make card` writes a page with the results of every shipped agent."""

import json
import re
import runpy
import sys
from pathlib import Path

import pytest

from catch_arena.suite.contents import SUITE
from catch_arena.suite.measures import AgentMeasures, ScenarioMeasures
from catch_arena.tournament.loading import shipped
from catch_arena.tournament.players import enter
from catch_arena.tournament.statistics.intervals import Estimate

ROOT = Path(__file__).parents[2]
with pytest.MonkeyPatch.context() as patch:
    patch.setattr(sys, "path", [str(ROOT / "scripts"), *sys.path])
    CARD = runpy.run_path(str(ROOT / "scripts" / "card.py"))


def reached(name, scores, blocks=4):
    """An agent with these scores in the first scenarios, and 0.6 in all others."""
    (agent,) = enter([name])
    scenarios = []
    for place, one in enumerate(SUITE.scenarios):
        score = scores[place] if place < len(scores) else 0.6
        estimate = Estimate(score, score - 0.01, score + 0.01)
        scenarios.append(
            ScenarioMeasures(
                name=one.name,
                held_out=one.held_out,
                by_block=(score,) * blocks,
                score=estimate,
                win_share=estimate,
                place=1,
                of=6,
                first=True if score > 0.65 else None if score > 0.5 else False,
                matches=8,
                forfeits={},
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
    assert "1 / 11 / 2" in row
    assert " / " not in re.search(r"^\| \[`idle`\].*", page, re.MULTILINE)[0]  # few blocks: nobody can be told apart
    assert "0.25 ms" in row
    assert "- Not good at: `scarce` (a target every two seconds), 0.20; `standard` (four hunters" in page
    assert "- Not good at: any scenario" in page
    assert f"- Matches: {8 * len(SUITE.scenarios)}, of which it forfeited 0." in page
    assert shipped()["patrol"] in page
    assert "It is a training opponent of the suite, and plays against itself there." in page


def test_newer_figures_of_references_take_the_place_of_older_ones():
    before = CARD["references_text"]('{"agents": []}', [reached("patrol", [0.3]), reached("nearest", [0.4])])
    after = CARD["references_text"](before, [reached("patrol", [0.5]), reached("idle", [0.0])])
    found = {one["agent"]: one["scenarios"]["standard"]["score_by_block"] for one in json.loads(after)["agents"]}
    assert found == {"patrol": [0.5] * 4, "nearest": [0.4] * 4}


def test_the_card_in_the_docs_is_of_this_suite_and_has_every_shipped_agent():
    page = (ROOT / "docs" / "reference" / "card.md").read_text()
    assert SUITE.digest in page, "make card"
    described = set(re.findall(r"^### (\w+)$", page, re.MULTILINE))
    missing = sorted(set(shipped()) - described)
    assert not missing, f"python scripts/card.py {' '.join(missing)}"
    assert described == set(shipped()), "make card"
