"""`make card`: the page says what was measured, of all agents that come with the package."""

import json
import math
import re
import runpy
from pathlib import Path

import pytest

from catch_arena.errors import ConfigError, OtherTournamentError, StoreError
from catch_arena.suite.contents import SUITE
from catch_arena.suite.measures import AgentMeasures, ScenarioMeasures
from catch_arena.suite.references import references_text
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.loading import shipped
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
                first=True if score > 0.65 else None if score > 0.5 else False,
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
    assert "1 / 11 / 2" in row
    assert " / " not in re.search(r"^\| \[`idle`\].*", page, re.MULTILINE)[0]  # few blocks: nobody can be told apart
    assert "0.25 ms" in row
    assert "- Not good at: `scarce` (a target every two seconds), 0.20; `standard` (four hunters" in page
    assert "- Not good at: any scenario" in page
    assert f"- Matches: {8 * len(SUITE.scenarios)}, of which it forfeited 0." in page
    assert shipped()["patrol"] in page
    assert "It is a training opponent of the suite, and plays against itself there." in page


def test_a_scenario_with_forfeits_is_a_weakness():
    page = CARD["page"]([reached("patrol", [0.9], forfeits=3)], 4)
    assert "- Not good at: `standard` (four hunters in turtlesim's arena), 0.90." in page
    assert "of which it forfeited 3." in page


def test_where_few_blocks_were_played_no_interval_is_given():
    one = reached("patrol", [], blocks=2)
    assert math.isnan(one.training.low)
    assert CARD["figure"](one.training) == "0.60 (?)"


def test_an_agent_is_put_into_the_card_and_the_others_stay():
    idle, patrol = reached("idle", [0.0] * len(SUITE.scenarios)), reached("patrol", [0.3, 0.7], SUITE.blocks)
    card = CARD["page"]([patrol, idle], 4).replace("0.25 ms", "9.99 ms")  # by another machine
    merged = CARD["merged"](card, CARD["page"]([reached("first", [0.5] * len(SUITE.scenarios))], 4), 4)
    assert [one.split("\n")[0] for one in merged.split("### ")[1:]] == ["patrol", "first", "idle"]
    for table in CARD["TABLE"].findall(merged):
        assert re.findall(r"^\| \[?`(\w+)`", table, re.MULTILINE) == ["patrol", "first", "idle"]
    added = re.search(r"^### first\n(.*?)\n\n### ", merged, re.MULTILINE | re.DOTALL)[1]
    assert "0.25 ms" in added
    assert "\n- Measured alone, by `scripts/card.py --blocks 4 first` on " in added
    others = "".join(line for line in merged.splitlines(keepends=True) if "`first`" not in line)
    assert others.replace(f"### first\n{added}\n\n", "") == card


def test_an_agent_that_is_in_the_card_is_replaced():
    card = CARD["page"]([reached("patrol", []), reached("idle", [0.0])], 4)
    better = CARD["page"]([reached("idle", [0.9] * len(SUITE.scenarios))], 4)
    merged = CARD["merged"](card, better, 4)
    assert re.findall(r"^### (\w+)$", merged, re.MULTILINE) == ["idle", "patrol"]
    assert merged.count("[`idle`]") == 1
    assert CARD["merged"](merged, better, 4) == merged


class PlayedBefore:
    """An evaluation that finds a folder with matches and tells `error`, as long as the folder is there."""

    def __init__(self, folder, error):
        self.folder, self.error, self.matches = folder, error, 2

    def play(self, *_):
        if self.folder.exists():
            raise self.error


def play_where(folder, error, monkeypatch):
    module = CARD["play"].__globals__
    monkeypatch.setitem(module, "Evaluation", lambda *_: PlayedBefore(folder, error))
    monkeypatch.setitem(module, "measure", lambda _: "measured")
    return CARD["play"](*enter(["idle"]), folder.parent, 1, 1)


def test_only_the_folder_of_another_tournament_is_played_anew(tmp_path, monkeypatch):
    """A path may hold whatever the message is made of."""
    changed = tmp_path / "a" / "b: is of another tournament" / "standard"
    changed.mkdir(parents=True)
    error = OtherTournamentError(f"{changed}: is of another tournament: its agents are others", changed)
    assert play_where(changed, error, monkeypatch) == "measured"
    assert not changed.exists()
    assert changed.parent.is_dir()


def test_what_else_a_store_says_removes_nothing(tmp_path, monkeypatch):
    folder = tmp_path / "x: is of another tournament" / "standard"
    folder.mkdir(parents=True)
    with pytest.raises(StoreError, match="is damaged"):
        play_where(folder, StoreError(f"{folder}: is damaged"), monkeypatch)
    assert folder.is_dir()


def test_nothing_is_put_into_a_card_of_another_suite():
    page = CARD["page"]([reached("idle", [])], 4)
    with pytest.raises(ConfigError, match="is of another suite than"):
        CARD["merged"](page.replace(SUITE.digest, "0" * 16), page, 4)


def test_references_that_are_not_played_anew_stay():
    known = {"nearest": {"standard": (0.25,)}}
    told = json.loads(references_text(SUITE, [reached("patrol", [], SUITE.blocks)], known))
    assert set(told["scores"]) == {"nearest", "patrol"}
    assert told["scores"]["nearest"] == {"standard": [0.25]}


def test_the_card_in_the_docs_is_of_this_suite_and_has_every_shipped_agent():
    page = (ROOT / "docs" / "reference" / "card.md").read_text()
    assert SUITE.digest in page, "make card"
    told = set(re.findall(r"^### (\w+)$", page, re.MULTILINE))
    missing = sorted(set(shipped()) - told)
    assert not missing, f"python scripts/card.py {' '.join(missing)}"
    assert told == set(shipped()), "make card"
