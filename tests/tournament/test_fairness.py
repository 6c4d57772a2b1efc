"""Fairness of seats, labels and the order of requests: proven every night, and an unfair arena is found."""

from random import Random

import numpy as np
import pytest
from tournament import invariance
from tournament.fairness import (
    LEVEL,
    audit,
    corrected,
    p_of_no_bias,
    permuted_steps,
    seat_plan,
    seats_differ,
)
from tournament.invariance import Step, lots

from catch_arena import scenario
from catch_arena.tournament.statistics.outcomes import Outcomes


@pytest.fixture(autouse=True)
def fewer_steps(monkeypatch):
    """Made-up ones: what is unfair here shows in the first few."""
    monkeypatch.setattr("tournament.fairness._STEPS", 300)


def identical(random, matches, bonus):
    """Scores of four seats, the third of which gets a bonus now and then."""
    scores = random.poisson(13, size=(matches, 4))
    scores[:, 2] += random.random(matches) < bonus
    ranks = 1 + (scores[:, None, :] > scores[:, :, None]).sum(axis=2)
    return Outcomes(4, np.arange(matches), np.tile(np.arange(4), (matches, 1)), scores, ranks)


def passes(outcomes):
    return all(check.passed for check in corrected(seats_differ(outcomes, "0123")))


@pytest.mark.parametrize(
    ("side", "names"), [("hunter", ("0+1", "2+3", "4+5", "6+7")), ("prey", ("prey 0", "prey 1", "prey 2", "prey 3"))]
)
def test_what_is_found_names_teams_by_their_seats_and_prey_by_its_index(side, names):
    """As the table does. The third of them catches most, or is caught most."""
    found = seats_differ(identical(np.random.default_rng(3), 200, 0.9), names, side)
    assert [check.question for check in found] == (
        ["Does a seat win more often than another?", "Does a seat catch more than another?"]
        if side == "hunter"
        else ["Does one prey win more often than another?", "Is one prey caught more often than another?"]
    )
    most = {"hunter": "(most: seat 4+5)", "prey": "(most: prey 2)"}[side]
    assert all(check.finding.endswith(most) for check in found)


@pytest.mark.parametrize(("name", "of_prey"), [("pairs", 0), ("tag", 1), ("herd", 3)])
def test_prey_is_asked_of_by_itself(name, of_prey):
    """Of one prey alone only what its name matters: there is no other in its match."""
    found = audit(scenario(name, time_limit_s=1), matches=100, seed=0)
    assert found.passed
    questions = [check.question for check in found.checks]
    assert len(set(questions)) == len(questions) == 8 + of_prey
    assert sum("prey" in question for question in questions) == of_prey
    assert (found.prey_twin_difference is not None) == (of_prey > 0)


def test_a_bonus_of_one_catch_in_two_matches_is_found_in_two_thousand():
    assert not passes(identical(np.random.default_rng(1), 2000, 0.5))


def test_fair_seats_are_accused_as_seldom_as_is_said():
    """1 % of 600 audits, but for three standard errors."""
    random = np.random.default_rng(2)
    accused = sum(not passes(identical(random, 300, 0.0)) for _ in range(600)) / 600
    assert accused <= LEVEL + 3 * (LEVEL / 600) ** 0.5


def test_what_is_always_so_is_no_chance():
    assert p_of_no_bias(np.tile([0.75, -0.25, -0.25, -0.25], (50, 1))) < 1e-6
    assert p_of_no_bias(np.zeros((50, 4))) == 1.0


def test_an_arbiter_that_serves_whoever_comes_first_is_found_out(monkeypatch):
    """A test double: the first of those who may have the target gets it."""
    true = invariance.arbitrate

    def partial(*, hunters, requests, **settings):
        asked = {seat: place for place, (seat, _) in reversed(list(enumerate(requests)))}
        first = min(asked, key=asked.__getitem__)
        return true(
            hunters=[(9.0, 9.0) if seat != first else at for seat, at in enumerate(hunters)],
            requests=requests,
            **settings,
        )

    monkeypatch.setattr(invariance, "arbitrate", partial)
    (order, _), _ = permuted_steps(scenario("standard"), 0)
    assert not order.passed


def test_an_arbiter_that_prefers_a_seat_is_found_out(monkeypatch):
    """A test double: seat 0 reaches further than the others."""
    true = invariance.arbitrate

    def partial(*, hunters, targets, **settings):
        target = next(iter(targets.values()))
        return true(hunters=[target, *hunters[1:]], targets=targets, **settings)

    monkeypatch.setattr(invariance, "arbitrate", partial)
    (_, labels), _ = permuted_steps(scenario("standard"), 0)
    assert not labels.passed


def test_lots_that_a_seat_always_wins_are_found_out(monkeypatch):
    monkeypatch.setattr(
        "tournament.fairness.lots",
        lambda rulings, config: {name: (tied, min(tied)) for name, (tied, _) in lots(rulings, config).items()},
    )
    _, (drawn,) = permuted_steps(scenario("standard"), 0)
    assert not drawn.passed


def test_made_up_steps_meet_every_verdict_that_a_contest_has():
    steps = [Step.drawn(scenario("standard"), Random(seed)) for seed in range(200)]
    verdicts = {ruling.verdict.name for step in steps for ruling in step.judged().values()}
    assert {"GRANTED", "LOST_CONTEST", "OUT_OF_REACH", "DUPLICATE", "UNKNOWN_TARGET"} <= verdicts


def test_requests_in_another_order_are_the_same_requests():
    step = Step.drawn(scenario("standard"), Random(5))
    other = step.in_another_order(Random(6))
    assert sorted(other.requests) == sorted(step.requests)
    for seat in range(4):
        own, others = ([name for asker, name in one.requests if asker == seat] for one in (step, other))
        assert own == others


def test_identical_agents_play_each_match_on_targets_of_its_own():
    plan = seat_plan(4, 50, 3)
    assert len({match.seed for match in plan}) == len({match.block for match in plan}) == len(plan) == 50
    assert {match.seating for match in plan} == {(0, 1, 2, 3)}


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["standard", "pairs", "tag"])
def test_the_arena_is_fair(name, monkeypatch):
    """2000 matches of identical agents, 500 of one agent under two names, and 2000 permuted steps."""
    monkeypatch.setattr("tournament.fairness._STEPS", 2000)
    found = audit(scenario(name), matches=2000, seed=0, jobs=2)
    assert [(check.question, check.finding, check.p) for check in found.checks if not check.passed] == []
