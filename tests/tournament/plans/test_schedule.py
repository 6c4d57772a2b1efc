"""Plans seat all agents equally often in every seat, use one seed for each block, and follow from one number."""

from collections import Counter
from math import comb

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tournament.seats import hunters

from catch_arena.errors import ConfigError
from catch_arena.tournament.execution.cost import match_counts
from catch_arena.tournament.plans.schedule import (
    FORMATS,
    plan_of,
    round_robin,
)


@st.composite
def plans(draw):
    """Any plan."""
    seats = draw(st.integers(2, 5))
    entrants, rounds = draw(st.integers(seats, 12)), draw(st.integers(1, 3))
    most = draw(st.sampled_from([1, 20_000]))  # of each format a sample, or all
    seed = draw(st.integers(0, 2**64 - 1))
    return plan_of(draw(st.sampled_from(FORMATS)), entrants, hunters(seats), rounds, seed, most)


@settings(deadline=None, max_examples=80)
@given(plans())
def test_a_block_of_any_plan_is_one_seed_and_every_rotation_of_its_players(plan):
    blocks = list(plan.blocks())
    assert [block[0].block for block in blocks] == list(range(len(blocks)))
    assert len({block[0].seed for block in blocks}) == len(blocks)
    for block in blocks:
        assert len({(match.seed, match.block) for match in block}) == 1
        first = block[0].seating
        assert len(set(first)) == len(first)
        assert [match.seating for match in block] == [first[turn:] + first[:turn] for turn in range(len(first))]
    ids = [match.id for block in blocks for match in block]
    assert ids == sorted(set(ids))
    assert len(ids) == plan.size
    assert list(plan.blocks()) == blocks
    assert [list(stage) for stage in plan.stages(list)] == [blocks]


def test_matches_are_counted_in_each_round_for_people():
    titles = [match.title(4) for match in round_robin(5, hunters(4), 2, 9)]
    assert titles == [f"round {turn}, match {number}" for turn in (1, 2) for number in range(1, 21)]


def test_a_plan_follows_from_its_seed_and_a_longer_one_begins_with_the_shorter():
    assert list(round_robin(6, hunters(4), 2, 9)) != list(round_robin(6, hunters(4), 2, 10))
    assert list(round_robin(6, hunters(4), 3, 9))[:120] == list(round_robin(6, hunters(4), 2, 9))


def test_this_plan_stays_what_it_is_whatever_the_python_or_the_machine():
    """Results of one seed are compared across machines: a change of this line is a break."""
    match = next(iter(round_robin(5, hunters(4), 1, 0)))
    assert (match.id, match.seed, match.seating) == ("r00001-g000001-s00", 2281132983424774186, (0, 1, 3, 2))
    assert match.agent_seeds[:2] == (6263321435955792150, 3195517759362832997)
    *_, match = plan_of("round-robin", 9, hunters(4), 2, 0, most=1)
    assert (match.id, match.seed, match.seating) == ("r00002-g000009-s03", 4307498912338749714, (7, 5, 0, 4))


@settings(deadline=None, max_examples=60)
@given(st.integers(2, 6).flatmap(lambda seats: st.tuples(st.integers(seats, 24), st.just(seats), st.integers(1, 4))))
def test_balanced_blocks_let_everybody_play_and_meet_equally(sizes):
    """No pair has more than five blocks more than another, however many rounds there are; docs/howto/tournaments.md."""
    entrants, seats, rounds = sizes
    plan = plan_of("round-robin", entrants, hunters(seats), rounds, seed=3, most=1)
    assert plan.parameters.get("matches_in_a_round", plan.size // rounds) == plan.size // rounds
    (least, most), (seldom, often) = match_counts(plan, entrants)
    assert least == most == plan.size * seats // entrants
    assert often - seldom <= 5 * seats


@pytest.mark.parametrize(("entrants", "seats", "rounds"), [(6, 4, 1), (2, 2, 3), (41, 4, 1)])
def test_in_a_gauntlet_the_first_is_in_every_match_and_meets_the_others_equally(entrants, seats, rounds):
    """With 40 in the field there are 9880 groups of three: balanced blocks stand in."""
    plan = plan_of("gauntlet", entrants, hunters(seats), rounds, seed=5)
    met = Counter(place for match in plan for place in match.seating)
    assert met[0] == plan.size
    assert len({met[place] for place in range(1, entrants)}) == 1
    assert len(met) == entrants
    if entrants < 10:
        assert met[1] == rounds * seats * comb(entrants - 2, seats - 2)


def test_of_more_groups_than_a_round_may_have_a_balanced_sample_is_played():
    assert plan_of("round-robin", 12, hunters(4), 1, 0).parameters["format"] == "round-robin"
    assert plan_of("round-robin", 30, hunters(4), 1, 0).parameters["format"] == "balanced"
    assert plan_of("round-robin", 30, hunters(4), 1, 0).size == 300
    assert plan_of("round-robin", 30, hunters(4), 1, 0, most=109_620).size == 109_620
    assert plan_of("round-robin", 150, hunters(2), 1, 0).size == 22_350
    fitting = plan_of("round-robin", 12, hunters(2), 1, 0, most=100)
    assert fitting.parameters == {"format": "balanced", "matches_in_a_round": 96, "rounds": 1}
    assert fitting.size == 8 * 12
    assert (
        plan_of("gauntlet", 41, hunters(4), 1, 0).size
        < plan_of("gauntlet", 41, hunters(4), 1, 0, most=10**6).size
        == 9880 * 4
    )


@pytest.mark.parametrize(
    ("form", "entrants", "seats", "rounds"),
    [
        ("round-robin", 4, 4, 10),
        ("round-robin", 5, 4, 3),
        ("round-robin", 4, 2, 4),
        ("round-robin", 7, 4, 1),
        ("gauntlet", 21, 2, 10),
        ("gauntlet", 5, 4, 4),
    ],
)
def test_without_a_number_of_rounds_each_entrant_plays_ten_blocks(form, entrants, seats, rounds):
    """Every figure of the standings then has an interval."""
    plan = plan_of(form, entrants, hunters(seats), None, 5)
    assert plan.parameters["rounds"] == rounds
    blocks = Counter(one for block in plan.blocks() for one in block[0].seating)
    assert min(blocks.values()) >= 10
    assert min(blocks.values()) * (rounds - 1) < 10 * rounds


@pytest.mark.parametrize(
    ("rounds", "seed", "message"), [(0, 0, "rounds must be at least 1"), (1, -1, "seed must be"), (10**6, 0, "at most")]
)
def test_a_plan_that_cannot_be_is_refused(rounds, seed, message):
    for form in FORMATS:
        with pytest.raises(ConfigError, match=message):
            plan_of(form, 60, hunters(4), rounds, seed)
    with pytest.raises(ConfigError, match="rounds must be at least 1 and at most 12499, got 12500"):  # of 8 sweeps each
        plan_of("round-robin", 12, hunters(2), 12_500, 0, most=100)


def test_a_format_that_cannot_be_is_refused():
    with pytest.raises(ConfigError, match=r"format must be one of .* got 'gauntlett'"):
        plan_of("gauntlett", 4, hunters(2), 1, 0)
    with pytest.raises(ConfigError, match="gauntlet needs at least 2 hunters or teams in a match, got 1"):
        plan_of("gauntlet", 4, hunters(1), 1, 0)


def test_a_plan_for_fewer_entrants_than_a_block_has_is_refused():
    for form, entrants in (("round-robin", 0), ("round-robin", 3), ("gauntlet", 0), ("gauntlet", 3)):
        with pytest.raises(ConfigError, match=f"entrants must be at least 4, the number in a block, got {entrants}"):
            plan_of(form, entrants, hunters(4), 1, 0)
