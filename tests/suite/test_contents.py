"""The benchmark suite never changes: scenarios, opponents, seeds and first matches."""

import dataclasses
import json
from pathlib import Path

import pytest
from suite.frozen import FILE, first_matches

from catch_arena.suite.contents import (
    QUICK_BLOCKS,
    REFERENCES,
    SUITE,
)
from catch_arena.suite.references import references, references_text

FROZEN = json.loads(FILE.read_text())
PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "suite.md").read_text()
each_scenario = pytest.mark.parametrize("scenario", SUITE.scenarios, ids=lambda one: one.name)


def test_version_1_is_what_it_was():
    """If this fails, you have changed a published suite, what is held out in it or who plays: make a version 2 instead.
    Settings that are new since then stand at their defaults, and are not in it.
    """
    assert json.loads(json.dumps(SUITE.facts())) == FROZEN["facts"]
    assert SUITE.digest == FROZEN["digest"]


def test_version_1_plays_as_it_did():
    """Rules, spawns and opponents too: a changed opponent changes every number that was published."""
    assert json.loads(json.dumps(first_matches())) == FROZEN["first_matches"]


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
def test_the_agent_plays_every_seat_of_a_block_once_on_the_same_targets(scenario):
    plan = SUITE.plan(scenario, SUITE.blocks)
    blocks = list(plan.blocks())
    assert len(blocks) == SUITE.blocks
    assert plan.size == sum(map(len, blocks)) == SUITE.blocks * len(scenario.parties)
    for block in blocks:
        assert sorted(match.seating.index(0) for match in block) == list(range(len(scenario.parties)))
        assert all(match.seating.count(0) == 1 for match in block)
        assert len({match.seed for match in block}) == 1
        assert len({tuple(sorted(match.seating)) for match in block}) == 1
    assert len({block[0].seed for block in blocks}) == SUITE.blocks


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
    assert references(SUITE, path) == {}
    path.write_text(references_text(dataclasses.replace(SUITE, seed=99), []))
    assert references(SUITE, path) == {}
