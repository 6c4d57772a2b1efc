"""What trained agents look at: the candidates, and what is told of each."""

import dataclasses
import math

import numpy as np
import pytest

import catch_arena
from catch_arena.agents.contested_by_time import Agent as ContestedByTime
from catch_arena.agents.triage import Agent as Triage
from catch_arena.batch_policy import BatchView
from catch_arena.layout import observation_size
from catch_arena.policy import Limits, View
from catch_arena.scenarios import SCENARIOS
from catch_arena.training.destinations import FEATURES, destinations

PLAYED = [name for name in SCENARIOS if name not in ("capstone", "squads", "faulty")]


def played(scenario, control, steps=40, arenas=3):
    """What hunters see while all chase what is near: limits, observations, masks."""
    config = catch_arena.scenario(scenario, control=control, max_cycles=steps)
    arena = catch_arena.VectorArena(config, arenas)
    columns = observation_size(config)
    observations = arena.reset(seed=3)[0][:, : config.hunters, :columns]
    source = np.random.default_rng(5)
    for _ in range(steps - 1):
        choices, commands = np.zeros(observations.shape[:2], int), np.ones((arenas, config.hunters + config.prey, 2))
        if control == "target":
            choices = source.integers(0, 2, observations.shape[:2])
        else:
            commands[:, : config.hunters] = source.uniform((0.3, -0.5), 1, (*observations.shape[:2], 2))
        observations = arena.step(choices, commands.astype(np.float32))[0][:, : config.hunters, :columns]
    return Limits.of(config, 0), observations[:, 0]


def view_of(observation, limits):
    """One hunter's, with a mask that follows from it."""
    view = View(observation.tolist(), (), limits)
    return View(
        view.observation, [1] + [int(rank <= len(view.targets)) for rank in range(1, limits.targets_seen + 1)], limits
    )


@pytest.mark.parametrize("scenario", PLAYED)
@pytest.mark.parametrize("control", ["target", "velocity"])
def test_one_view_and_a_batch_are_described_alike(scenario, control):
    """Whatever the size of the blocks in which they are described."""
    limits, observations = played(scenario, control)
    together = destinations(BatchView(observations, np.zeros((3, 0)), limits))
    assert together.features.shape == (3, together.places + limits.targets_seen, len(FEATURES))
    assert np.abs(together.features).max() < 12
    for row, observation in enumerate(observations):
        alone = destinations(view_of(observation, limits))
        for one, of_batch in zip(alone[:-1], together[:-1], strict=True):
            np.testing.assert_allclose(of_batch[row], one[0], rtol=0, atol=1e-6)


def test_candidates_lie_where_the_targets_are_and_absent_ones_are_not_legal():
    """Behind the places, by rank, in the hunter's own frame."""
    limits, observations = played("standard", "velocity")
    for observation in observations:
        view, seen = view_of(observation, limits), destinations(view_of(observation, limits))
        assert seen.legal[0, : seen.places].all()
        assert seen.legal[0, seen.places :].sum() in (len(view.targets), len(view.targets) - 1)
        for target in view.targets:
            at = seen.places + target.rank - 1
            assert (seen.forward[0, at], seen.left[0, at]) == (target.forward, target.left)
            if seen.legal[0, at]:
                told = dict(zip(FEATURES, seen.features[0, at].tolist(), strict=True))
                assert told["distance"] * 3 == pytest.approx(target.distance)
                assert told["bearing"] * math.pi == pytest.approx(abs(target.bearing), abs=1e-5)
        assert not seen.features[0][~seen.legal[0]].any()


@pytest.mark.parametrize(("agent", "control"), [(Triage, "velocity"), (ContestedByTime, "target")])
def test_what_is_preferred_is_what_the_scripted_agent_does(agent, control):
    """Found anew from the view: the race that suits best, unless it is lost by far."""
    from catch_arena.agents.patrol import drive

    compared = 0
    for scenario in ("standard", "duel", "scarce", "crowd"):
        limits, observations = played(scenario, control, steps=60, arenas=6)
        for observation in observations:
            view, seen = view_of(observation, limits), destinations(view_of(observation, limits))
            (preferred,) = seen.preferred
            action = agent().act(view)
            if control == "target":
                assert preferred == action
            elif preferred >= seen.places:
                assert action == pytest.approx(drive(seen.forward[0, preferred], seen.left[0, preferred], view))
            compared += preferred >= seen.places
    assert compared > 8


def test_the_order_of_equally_ranked_rivals_says_nothing():
    """Rivals are told in the order of their arrival, whatever their ranks."""
    limits, observations = played("standard", "velocity")
    first = 10 + 5 * limits.targets_seen
    for observation in observations:
        swapped = observation.copy()
        swapped[first:].reshape(3, 7)[:] = observation[first:].reshape(3, 7)[[2, 0, 1]]
        one, other = (destinations(view_of(seen, limits)) for seen in (observation, swapped))
        np.testing.assert_allclose(one.features, other.features, atol=1e-6)


def test_a_target_that_drives_off_is_met_farther_ahead():
    """Where both are at the same time: the hunter's way takes as long as the target's."""
    config = catch_arena.scenario("wander", control="velocity")
    limits = Limits.of(config)
    observation = np.zeros(catch_arena.parallel_env(config).observation_space("hunter_0").shape[0])
    observation[:4] = (1, 5, 1, 0)
    observation[10:18] = (3, 0, 1, 0, 0, 1, 0, 1)  # three metres ahead, and away at 1 m/s
    seen = destinations(view_of(observation, limits))
    met = seen.forward[0, seen.places]
    assert 3.9 < met <= 4.5  # R2.5: 2 m/s against 1 m/s
    assert seen.left[0, seen.places] == 0


def test_a_target_within_reach_that_no_rival_is_nearer_to_is_passed_over():
    """It is requested for whoever drives by (R4.4); under target control it has to be chosen."""
    for control, legal in (("velocity", False), ("target", True)):
        limits = dataclasses.replace(Limits.of(catch_arena.scenario("duel")), control=control)
        observation = np.zeros(57)
        observation[:4] = (5, 5, 1, 0)
        observation[10:13] = (0.2, 0, 1)
        observation[15:18] = (2, 0, 1)
        observation[50:53] = (1, 0, 1)
        seen = destinations(view_of(observation, limits))
        assert seen.legal[0, seen.places] == legal
        assert seen.legal[0, seen.places + 1]
