"""Agents that choose one of a few commands, alone and in batches."""

import numpy as np
import pytest

from catch_arena import Limits, PreyLimits, VectorArena, View, scenario
from catch_arena.batch_policy import BatchView, PreyBatchView
from catch_arena.errors import ConfigError
from catch_arena.layout import columns, prey_columns
from catch_arena.training import Mlp, fit_observation
from catch_arena.training.flat import COMMANDS, FlatAgent


def network(inputs, outputs=15, seed=3):
    """A small network with random weights."""
    source = np.random.default_rng(seed)
    return Mlp(
        [(source.normal(0, 0.5, (8, inputs)), np.zeros(8)), (source.normal(size=(outputs, 8)), np.zeros(outputs))]
    )


def driven(name):
    """Arenas after some steps."""
    arena = VectorArena(name, 6, control="velocity", max_cycles=40)
    arena.reset(2)
    source = np.random.default_rng(1)
    for _ in range(12):
        agents = arena.num_hunters + arena.num_prey
        observations, *_ = arena.step(commands=source.uniform(-1, 1, (6, agents, 2)))
    return arena.config, observations


@pytest.mark.parametrize("name", ["standard", "tag", "fog", "partners"])
def test_hunters_act_in_a_batch_as_they_do_alone(name):
    """By the command with the greatest output, for the columns of the arena in which the network was trained."""
    config, observations = driven(name)
    trained = network(len(columns(scenario("tag"))))
    agent, limits = FlatAgent(trained, "tag"), Limits.of(config)
    seen = observations[:, : config.hunters, : len(columns(config))].reshape(-1, len(columns(config)))
    view = BatchView(seen, np.zeros((len(seen), 0), np.int8), limits)
    acted = agent.act_batch(view)
    assert acted.tolist() == [list(agent.act(View(row.tolist(), [], limits))) for row in seen]
    assert acted.tolist() == COMMANDS[trained(fit_observation(view, "tag")).argmax(axis=1)].tolist()
    assert len(np.unique(acted, axis=0)) > 1


@pytest.mark.parametrize("name", ["tag", "herd"])
def test_prey_acts_in_a_batch_as_it_does_alone(name):
    config, observations = driven(name)
    size, limits = len(prey_columns(config)), PreyLimits.of(config)
    agent = FlatAgent(network(len(prey_columns(scenario("tag")))), "tag")
    seen = observations[:, config.hunters :, :size].reshape(-1, size)
    acted = agent.act_batch(PreyBatchView(seen, limits))
    assert acted.tolist() == [list(agent.act(limits.view(row.tolist(), ()))) for row in seen]
    assert len(np.unique(acted, axis=0)) > 1


def test_an_agent_plays_from_the_file_of_its_network(tmp_path):
    made = network(len(columns(scenario("duel"))))
    made.save(tmp_path / "made.npz")
    _, observations = driven("duel")
    limits = Limits.of(scenario("duel", control="velocity"))
    view = View(observations[0, 0].tolist(), [], limits)
    assert FlatAgent(tmp_path / "made.npz", "duel").act(view) == FlatAgent(made, "duel").act(view)


def test_a_network_with_another_number_of_outputs_is_refused(tmp_path):
    network(57, outputs=9).save(tmp_path / "mine.npz")
    with pytest.raises(ConfigError, match=r"^the network must have 15 outputs, got 9$"):
        FlatAgent(tmp_path / "mine.npz", "duel")
