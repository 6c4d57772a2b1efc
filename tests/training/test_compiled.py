"""A compiled function of a hunter's view returns the same for many hunters as in plain Python."""

import math

import numpy as np
import pytest

import catch_arena
from catch_arena.batch_policy import BatchView
from catch_arena.core.modes import INTERPRETED
from catch_arena.layout import observation_size
from catch_arena.policy import Limits, View
from catch_arena.training import compiled
from catch_arena.training.compiled import commands_for_each, ranks_for_each

SHARE = 0.25


def everything(view):
    """A number that depends on all that may be read, and one that depends on the limits."""
    total = view.x + 2 * view.y + 3 * view.heading_cos + 4 * view.heading_sin + 5 * view.linear_velocity
    total += view.angular_velocity + view.time_left + view.score
    total += 6 * view.distance_integral + 7 * view.bearing_integral
    for place, target in enumerate(view.targets):
        total += (place + 1) * part(target.forward, target.left, target.age)
        total += part(target.heading_cos, target.heading_sin, target.linear_velocity) + target.active
    for rival in view.rivals:
        total += part(rival.forward, rival.left, rival.score_difference) + rival.mate
        total -= part(rival.heading_cos, rival.heading_sin, rival.linear_velocity)
    limits = view.limits
    return total, limits.side_m * limits.targets_seen + limits.alarm_m + (0.5 if limits.teams else SHARE)


def part(one, another, third=1.0):
    return SHARE * math.hypot(one, another) + math.atan2(another, one) * third


def oldest(view):
    best = 0
    for rank in range(1, len(view.targets) + 1):
        if best == 0 or view.targets[rank - 1].age > view.targets[best - 1].age:
            best = rank
    return best


@pytest.mark.parametrize("scenario", ["standard", "evasive", "fog", "pairs", "duel"])
def test_it_reads_what_a_view_has(scenario):
    config = catch_arena.scenario(scenario, control="target")
    arena = catch_arena.VectorArena(config, 6)
    arena.reset(seed=3)
    for _ in range(25):
        observations, *_ = arena.step(np.ones((6, config.hunters), dtype=int))
    observations, limits = observations[:, 1, : observation_size(config)], Limits.of(config)
    batch = BatchView(observations, np.ones((6, 1 + limits.targets_seen), np.int8), limits)
    views = [View(row.tolist(), (), limits) for row in observations]
    assert any(view.targets for view in views)
    np.testing.assert_allclose(commands_for_each(everything, batch), [everything(view) for view in views], atol=1e-9)
    assert ranks_for_each(oldest, batch).tolist() == [oldest(view) for view in views]
    assert commands_for_each(everything, BatchView(observations[:0], batch.masks[:0], limits)).shape == (0, 2)


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
def test_code_that_is_kept_is_of_these_functions_and_numbers(monkeypatch):
    """Numba's cache compares one file only, so the name has a digest."""

    def name():
        compiled._compiled.cache_clear()
        return compiled._compiled(everything, compiled._write_command).py_func.__qualname__

    first = name()
    assert name() == first
    monkeypatch.setitem(globals(), "SHARE", 0.75)
    assert name() != first
    monkeypatch.undo()
    assert name() == first
    monkeypatch.setitem(globals(), "part", oldest)
    assert name() != first
