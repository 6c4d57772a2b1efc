"""The benchmark suite never changes: scenarios, opponents, seeds and first matches."""

import dataclasses
import json
from pathlib import Path

import pytest
from suite.frozen import file_of, first_matches

from catch_arena.suite.contents import LADDER, QUICK_BLOCKS, REFERENCES, SUITE
from catch_arena.suite.measures import REFERENCES_FILE, references
from catch_arena.tournament.parties import Parties

PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "suite.md").read_text()
SUITES = (SUITE, LADDER)
each_suite = pytest.mark.parametrize("suite", SUITES, ids=lambda one: one.name)
each_scenario = pytest.mark.parametrize(
    ("suite", "scenario"), [pytest.param(suite, one, id=one.name) for suite in SUITES for one in suite.scenarios]
)


@each_suite
def test_version_1_is_what_it_was(suite):
    """If this fails, you have changed a published suite, what is held out in it or who plays: make a version 2 instead.
    Settings that are new since then stand at their defaults, and are not in it.
    """
    frozen = json.loads(file_of(suite).read_text())
    assert json.loads(json.dumps(suite.facts())) == frozen["facts"]
    assert suite.digest == frozen["digest"]
    assert f"**{suite.digest}**" in PAGE


@each_suite
def test_version_1_plays_as_it_did(suite):
    """Rules, spawns and opponents too: a changed opponent changes every number that was published."""
    assert json.loads(json.dumps(first_matches(suite))) == json.loads(file_of(suite).read_text())["first_matches"]


@pytest.mark.parametrize("change", ["name", "blocks", "seed", "scenarios", "an opponent", "a setting"])
def test_the_digest_stands_for_everything(change):
    first, *others = SUITE.scenarios
    changed = {
        "name": {"name": "catch_arena_suite_v2"},
        "blocks": {"blocks": SUITE.blocks + 1},
        "seed": {"seed": SUITE.seed + 1},
        "scenarios": {"scenarios": tuple(others)},
        "an opponent": {"scenarios": (dataclasses.replace(first, opponents=first.opponents[1:]), *others)},
        "a setting": {"scenarios": (dataclasses.replace(first, config=first.config.replace(reach_m=0.31)), *others)},
    }[change]
    assert dataclasses.replace(SUITE, **changed).digest != SUITE.digest


@each_scenario
def test_the_agent_plays_every_seat_of_a_block_once_on_the_same_targets(suite, scenario):
    plan, parties = suite.plan(scenario, suite.blocks), len(Parties.of(scenario.config))
    blocks = list(plan.blocks())
    assert len(blocks) == suite.blocks
    assert plan.size == sum(map(len, blocks)) == suite.blocks * parties
    for block in blocks:
        assert sorted(match.seating.index(0) for match in block) == list(range(parties))
        assert all(match.seating.count(0) == 1 for match in block)
        assert len({match.seed for match in block}) == 1
        assert len({tuple(sorted(match.seating)) for match in block}) == 1
    assert len({block[0].seed for block in blocks}) == suite.blocks


def test_a_quick_look_plays_the_first_matches_of_the_protocol():
    for one in SUITE.scenarios:
        whole = list(SUITE.plan(one, SUITE.blocks))
        quick = list(SUITE.plan(one, QUICK_BLOCKS))
        assert whole[: len(quick)] == quick


def test_references_are_of_this_suite_and_whole():
    """`make card` writes them."""
    found = references(SUITE)
    assert set(found) == set(REFERENCES)
    for scores in found.values():
        assert list(scores) == [one.name for one in SUITE.scenarios]
        assert all(len(of) == SUITE.blocks and all(0 <= score <= 1 for score in of) for of in scores.values())


def test_references_of_another_suite_are_not_compared_with(tmp_path):
    path = tmp_path / "references.json"
    path.write_text(REFERENCES_FILE.read_text().replace(SUITE.digest, dataclasses.replace(SUITE, seed=99).digest))
    assert references(SUITE, path) == {}
