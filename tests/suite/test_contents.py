"""What is in the suite: frozen, fair to every seat, and held out where it says so."""

import dataclasses
import json
from collections import Counter
from pathlib import Path

import pytest
from suite.frozen import FILE, first_matches

from catch_arena.scenarios import SCENARIOS
from catch_arena.suite.contents import (
    HELD_OUT_OPPONENTS,
    QUICK_BLOCKS,
    REFERENCES,
    SUITE,
    TRAINING_OPPONENTS,
    SuiteScenario,
)
from catch_arena.suite.references import references, references_text
from catch_arena.tournament.entrants import shipped
from catch_arena.tournament.statistics.aggregates import FEWEST_RUNS

FROZEN = json.loads(FILE.read_text())
PAGE = (Path(__file__).parents[2] / "docs" / "suite.md").read_text()
each_scenario = pytest.mark.parametrize("scenario", SUITE.scenarios, ids=lambda one: one.name)


def test_version_1_is_what_it_was():
    """If this fails, you have changed a published suite: make a version 2 instead. Settings that are new since then
    stand at their defaults, and are not in it.
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


def test_training_scenarios_are_shipped_and_held_out_ones_are_not():
    for one in SUITE.part(held_out=False):
        assert SCENARIOS[one.name].replace(control="target") == one.config  # agents play under their own
        assert set(one.opponents) <= set(TRAINING_OPPONENTS)
    known = [*SCENARIOS.values()]
    for one in SUITE.part(held_out=True):
        assert one.name not in SCENARIOS
        assert one.config not in known or one.opponents == HELD_OUT_OPPONENTS


def test_opponents_are_shipped_and_on_one_list_only():
    assert not set(TRAINING_OPPONENTS) & set(HELD_OUT_OPPONENTS)
    assert set(TRAINING_OPPONENTS) | set(HELD_OUT_OPPONENTS) | set(REFERENCES) <= set(shipped())


def test_held_out_scenarios_differ_in_all_that_they_should():
    held_out = [one.config for one in SUITE.part(held_out=True)]
    trained = [one.config for one in SUITE.part(held_out=False)]
    for name in ("hunters", "side_m", "max_speed_mps", "spawn_frequency_hz", "view_radius_m", "target_speed_mps"):
        assert {getattr(one, name) for one in held_out} - {getattr(one, name) for one in trained}, name


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


@each_scenario
def test_every_opponent_is_met_equally_often(scenario):
    met = Counter(index for block in range(SUITE.blocks) for index in scenario.lineup(block))
    assert set(met) == set(range(len(scenario.opponents)))
    assert len(set(met.values())) == 1


def test_where_there_are_more_seats_than_opponents_all_of_them_play_and_some_twice():
    config = SCENARIOS["crowd"].replace(hunters=9)
    one = SuiteScenario("nine", config, ("nearest", "first", "patrol"), held_out=True, about="")
    lineups = [Counter(one.lineup(block)) for block in range(3)]
    assert all(sum(lineup.values()) == 8 and set(lineup.values()) == {2, 3} for lineup in lineups)
    assert len({tuple(sorted(lineup.items())) for lineup in lineups}) == 3


def test_a_quick_look_plays_the_first_matches_of_the_protocol():
    for one in SUITE.scenarios:
        whole = list(SUITE.plan(one, SUITE.blocks))
        quick = list(SUITE.plan(one, QUICK_BLOCKS))
        assert whole[: len(quick)] == quick


def test_no_two_scenarios_have_a_seed_in_common():
    seeds = [match.seed for one in SUITE.scenarios for match in SUITE.plan(one, SUITE.blocks)]
    assert len(set(seeds)) == SUITE.blocks * len(SUITE.scenarios)


def test_the_protocol_has_blocks_enough_for_intervals():
    assert SUITE.blocks >= FEWEST_RUNS


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


def test_the_page_lists_every_scenario_and_every_opponent():
    for one in SUITE.scenarios:
        assert f"| `{one.name}` |" in PAGE
    for name in (*TRAINING_OPPONENTS, *HELD_OUT_OPPONENTS, *REFERENCES):
        assert f"`{name}`" in PAGE
    assert SUITE.digest in PAGE
