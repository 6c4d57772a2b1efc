"""An observation of one scenario is fitted to the columns of a network from another."""

from itertools import product

import numpy as np
import pytest

import catch_arena
from catch_arena.batch_policy import BatchView
from catch_arena.errors import ConfigError
from catch_arena.layout import columns, prey_columns
from catch_arena.scenarios import SCENARIOS
from catch_arena.training import fit_mask, fit_observation

STEPS = 12


def views(name, **settings):
    """Yield the views of all hunters after some steps."""
    env = catch_arena.parallel_env(name, **settings)
    observations, infos = env.reset(seed=3)
    hunters = [agent for agent in env.agents if agent.startswith("hunter")]
    for agent in env.agents:
        env.action_space(agent).seed(1)
    for _ in range(STEPS):
        actions = {agent: env.action_space(agent).sample() for agent in env.agents}
        if env.config.control == "target":
            actions |= {agent: int(infos[agent]["action_mask"][1]) for agent in hunters}
        observations, _, _, _, infos = env.step(actions)
    for seat, agent in enumerate(hunters):
        mask = infos[agent].get("action_mask", [])
        yield catch_arena.View(observations[agent].tolist(), list(mask), catch_arena.Limits.of(env.config, seat))


@pytest.mark.parametrize("name", [name for name in SCENARIOS if name != "tag"])
def test_each_column_has_the_value_of_its_name_and_else_0(name):
    """By the table that the space is made from, which the function does not read."""
    for view, trained in product(views(name), ("standard", "crowd", "evasive", "pairs", "unequal")):
        here = dict(zip([column.name for column in columns(SCENARIOS[name])], view.observation, strict=True))
        expected = [here.get(column.name, 0.0) for column in columns(SCENARIOS[trained])]
        fitted = fit_observation(view, trained)
        assert fitted.dtype == np.float32
        assert fitted.tolist() == np.float32(expected).tolist()
        again = catch_arena.View(fitted.tolist(), view.mask, catch_arena.Limits.of(SCENARIOS[trained], 0))
        seen = min(len(view.targets), again.limits.targets_seen)
        assert [(one.rank, one.forward, one.age) for one in again.targets] == [
            (one.rank, np.float32(one.forward), np.float32(one.age)) for one in view.targets[:seen]
        ]


@pytest.mark.parametrize(("here", "trained"), [(3, 8), (8, 3), (1, 16), (16, 2)])
def test_a_choice_with_the_fitted_mask_is_legal_here(here, trained):
    """Ranks that are not in view are masked, and those that the network does not have are left out."""
    config = catch_arena.scenario("standard", observed_targets=trained)
    for view in views("standard", observed_targets=here):
        mask = fit_mask(view, config)
        assert mask.shape == (trained + 1,)
        assert mask[0]
        legal = np.flatnonzero(view.mask)
        assert np.flatnonzero(mask).tolist() == [one for one in legal if one <= trained]


@pytest.mark.parametrize("trained", ["duel", "crowd", "pairs", "unequal"])
def test_many_at_once_are_fitted_as_one(trained):
    seen = list(views("standard"))
    batch = BatchView(
        np.array([view.observation for view in seen], np.float32),
        np.array([view.mask for view in seen], np.int8),
        seen[0].limits,
    )
    assert fit_observation(batch, trained).tolist() == [fit_observation(view, trained).tolist() for view in seen]
    assert fit_mask(batch, trained).tolist() == [fit_mask(view, trained).tolist() for view in seen]


@pytest.mark.parametrize(("trained", "width"), [("standard", 71), ("wander", 95), ("pairs", 74)])
def test_a_network_of_another_width_gets_the_columns_of_the_first_networks(trained, width):
    """Whatever columns have been added since."""
    for view in views("standard"):
        assert fit_observation(view, trained, 1).shape == (width,)
        own_width = len(columns(SCENARIOS[trained]))
        assert fit_observation(view, trained, own_width).tolist() == fit_observation(view, trained).tolist()


@pytest.mark.parametrize(("here", "trained"), [("herd", "tag"), ("tag", "herd"), ("herd", "herd")])
def test_prey_is_fitted_by_the_names_of_its_columns(here, trained):
    """One prey, and many."""
    config = catch_arena.scenario(here)
    observations, _ = catch_arena.parallel_env(config).reset(seed=3)
    seen = np.array([observations[name] for name in config.prey_names])
    names, limits = [column.name for column in prey_columns(config)], catch_arena.PreyLimits.of(config)
    expected = [
        [dict(zip(names, row, strict=True)).get(column.name, 0.0) for column in prey_columns(SCENARIOS[trained])]
        for row in seen.tolist()
    ]
    assert fit_observation(catch_arena.PreyBatchView(seen, limits), trained).tolist() == expected
    assert fit_observation(catch_arena.PreyView(seen[0].tolist(), limits), trained).tolist() == expected[0]


def test_prey_is_not_fitted_to_a_scenario_without_prey():
    limits = catch_arena.PreyLimits.of(SCENARIOS["tag"])
    with pytest.raises(ConfigError, match="trained must be a scenario with prey for a view of prey, got 'standard'"):
        fit_observation(catch_arena.PreyView([0.0] * 27, limits), "standard")


def test_who_drives_itself_has_no_choices():
    for view in views("standard", control="velocity"):
        assert fit_mask(view, "standard").shape == (0,)
        assert fit_observation(view, "duel").shape == (57,)
