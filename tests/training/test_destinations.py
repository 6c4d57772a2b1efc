"""A trained agent under velocity control passes over a target that is as good as caught."""

import dataclasses

import numpy as np

import catch_arena
from catch_arena.policy import Limits, View
from catch_arena.training.destinations import destinations


def view_of(observation, limits):
    """One hunter's, with a mask that follows from it."""
    view = View(observation.tolist(), (), limits)
    return View(
        view.observation, [1] + [int(rank <= len(view.targets)) for rank in range(1, limits.targets_seen + 1)], limits
    )


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
