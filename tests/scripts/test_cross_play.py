"""The card's tables of learned agents against each other say who played whom, and how they did."""

import re
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

from catch_arena.scenarios import scenario
from catch_arena.tournament.agent_spec import ladder_names

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def cross_play():
    sys.path.insert(0, str(ROOT / "scripts"))
    try:
        return runpy.run_path(str(ROOT / "scripts" / "cross_play.py"))
    finally:
        sys.path.remove(str(ROOT / "scripts"))
        del sys.modules["card"]


def test_catches_are_by_hunter_prey_and_match(cross_play):
    config = scenario("tag", time_limit_s=10.0)
    found = cross_play["chase"](config, ["intercept", StandsStill], ["flee", StandsStill], 6)
    assert found.shape == (2, 2, 6)
    assert found[1].mean() < 0.5 < found[0].mean()
    assert found[0, 1].mean() > found[0, 0].mean()
    assert len(set(found[0, 0].tolist())) > 1, "each match has a seed of its own"


class StandsStill:
    control = "velocity"

    def reset(self, seed):
        """Begin."""

    def act_batch(self, view):
        return np.zeros((len(view.observations), 2), np.float32)


def test_a_party_wins_against_the_others_from_each_of_its_places(cross_play):
    players = ["nearest", StandsStill]
    found = cross_play["wins"](scenario("standard", time_limit_s=10.0), players, [[0], [1], [1]], [1, 0, 1], 8)
    assert found.shape == (3, 8)
    assert found.mean(axis=1).tolist() == pytest.approx([1.0, 0.0, 0.25], abs=0.05)  # a few targets appear within reach
    teams = scenario("partners", time_limit_s=20.0)
    found = cross_play["wins"](teams, ["together", StandsStill], [[0, 0], [0, 1]], [1, 0], 8)
    assert found[0].mean() > 0.6
    assert found[1].mean() == 0.0, "a hunter that stands still is of no use to its team-mate"


def test_who_catches_more_climbs_higher(cross_play):
    players = ["nearest", StandsStill, "contested", "patrol", StandsStill]
    found = cross_play["climb"](scenario("standard", time_limit_s=10.0), players, 20)
    assert sum(map(len, found)) == 4 * 20
    means = [values.mean() for values in found]
    assert max(means[1], means[4]) < min(means[0], means[2], means[3])
    beaten = sum(values.sum() for values in found)
    assert beaten == pytest.approx(20 * 4 / 2), "half of all comparisons are won"


def test_a_table_has_the_mean_and_the_worst_of_each_row(cross_play):
    values = np.array([[[0.0, 2.0] * 4, [4.0, 6.0] * 4], [[3.0] * 8, [3.0] * 8]])
    labels = ["seed 1, 9k", "`script`"]
    *head, first, second, end = cross_play["table"]("who", labels, ["seed 1, 3k", "seed 2, 3k"], values, "catches")
    assert head == ["| who | seed 1, 3k | seed 2, 3k | mean | worst |", "|---|---|---|---|---|"]
    assert re.fullmatch(r"\| seed 1, 9k \| \*\*1\.0 \(.*\)\*\* \| 5\.0 \(.*\) \| 3\.0 \(.*\) \| 1\.0 \(.*\) \|", first)
    assert second == "| `script` |" + " 3.0 (3.0 to 3.0) |" * 4
    assert end == ""
    prey = list(cross_play["table"]("who", labels, ["a", "b"], values, "catches", max))
    assert re.search(r"\| 5\.0 \([^|]*\|$", prey[2])


def test_the_section_names_who_played_and_is_kept_by_the_card(cross_play):
    """`scripts/cross_play.py` writes it again."""
    card = (ROOT / "docs" / "reference" / "card.md").read_text()
    _, heading, section = card.partition(cross_play["CROSS_PLAY"])
    assert heading
    rungs, last = cross_play["rungs"], cross_play["last"]
    sides = {tuple(name.removeprefix("ladder.").split("_")[:2]) for name in ladder_names()}
    for side in sides:
        for one in last(rungs(*side)):
            assert f"| {one.label} |" in section


def test_tiny_numbers_make_a_whole_section(cross_play, monkeypatch):
    globals_of = cross_play["section"].__globals__
    short = {name: scenario(name, time_limit_s=2.0) for name in ("tag", "pack", "partners", "standard")}
    monkeypatch.setitem(globals_of, "scenario", short.get)
    text = cross_play["section"](4)
    assert text.startswith("## Cross-play of learned agents\n\n")
    assert re.findall(r"^### (.*)$", text, re.MULTILINE)[:3] == [
        "Hunters and prey in `tag`",
        "Hunters and prey in `pack`",
        "A team in `partners`",
    ]
    assert "| agent, by team-mate |" in text
    assert "separated from the age before" in text
    assert "--matches 4" in text
    assert "\n\n\n" not in text
