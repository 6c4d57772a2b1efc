"""The features of trained agents are the same for one view and for a batch."""

import dataclasses

import numpy as np
import pytest

import catch_arena
from catch_arena.batch_policy import BatchView
from catch_arena.layout import observation_size
from catch_arena.policy import Limits, View
from catch_arena.scenarios import SCENARIOS
from catch_arena.training.destinations import FEATURES, destinations

PLAYED = [name for name in SCENARIOS if name not in ("capstone", "squads", "faulty")]


def played(scenario, control, steps=40, arenas=3):
    """Return the limits and the observations of hunters that chase the nearest target."""
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


def test_a_target_within_reach_that_no_rival_is_nearer_to_is_passed_over():
    """R4.4 requests it; under target control it has to be chosen."""
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
        waiting = destinations(view_of(observation, dataclasses.replace(limits, hunters_per_catch=2)))
        assert waiting.legal[0, waiting.places]  # it is not caught before a partner is there (R5.10)
