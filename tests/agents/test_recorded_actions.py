"""Shipped agents act on recorded views as they always have.

`PYTHONPATH=tests python tests/agents/test_recorded_actions.py` writes tests/data/actions.npz. That is right only if an
agent is meant to play differently.
"""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import catch_arena
from catch_arena.batch_policy import BatchView, PreyBatchView
from catch_arena.layout import observation_size, prey_observation_size
from catch_arena.policy import player_limits
from catch_arena.tournament.loading import shipped

FILE = Path(__file__).parents[1] / "data" / "actions.npz"
SCENARIOS = ("standard", "duel", "scarce", "crowd", "evasive", "fog", "haze", "pairs", "partners", "unequal", "tag")
AGENTS = [name for name in shipped() if name != "random"]
WITH_PREY = ("tag", "herd", "pack")
PREY = ("flee", "corners")
STEPS = 24


def agent_of(name, kind="Agent"):
    return getattr(import_module(f"catch_arena.agents.{name}"), kind)


def views(scenario, control, side="hunter"):
    """Yield the view of each hunter, or each prey, of a batch in turn, while all drive at random."""
    config = catch_arena.scenario(scenario, control=control, max_cycles=10 * STEPS)
    arena = catch_arena.VectorArena(config, 3)
    limits = [player_limits(config, seat) for seat in range(config.hunters + config.prey)]
    seats = [seat for seat, its in enumerate(limits) if its.side == side]
    size = observation_size(config) if side == "hunter" else prey_observation_size(config)
    source = np.random.default_rng(7)
    observations, infos = arena.reset(seed=19)
    for step in range(STEPS):
        row, seat = step % 3, seats[step % len(seats)]
        mask = infos["action_mask"][row, seat].tolist() if control == "target" else ()
        yield limits[seat].view(observations[row, seat, :size].tolist(), mask)
        for _ in range(7):  # an action holds for some steps: so hunters come far enough to catch
            commands = source.uniform((0.3, -0.5), 1.0, (3, config.hunters + config.prey, 2)).astype(np.float32)
            choices = np.ones((3, config.hunters), int) * (source.random((3, config.hunters)) < 0.5)
            if control == "velocity":
                observations, *_ = arena.step(commands=commands)
            else:
                hunts = commands if config.prey else None
                observations, _, _, _, infos = arena.step(choices, hunts)


def decided(name, scenario):
    """An agent's actions on these views, (STEPS, numbers), and the views."""
    agent, seen = agent_of(name)(), list(views(scenario, getattr(agent_of(name), "control", "target")))
    agent.reset(1)
    return np.array([agent.act(view) for view in seen], np.float32), seen


@pytest.mark.parametrize("name", AGENTS)
def test_agents_do_what_they_did(name):
    """Up to the last bits of float32 in a network; one that acts for many hunters does the same for them."""
    tolerance = 1e-4 if name.startswith("ppo_") else 1e-6
    with np.load(FILE) as recorded:
        for scenario in SCENARIOS:
            actions, seen = decided(name, scenario)
            np.testing.assert_allclose(actions, recorded[f"{name}-{scenario}"], rtol=0, atol=tolerance)
            agent = agent_of(name)()
            if hasattr(agent, "act_batch"):
                for view, action in zip(seen[::6], actions[::6], strict=True):
                    masks = np.array([view.mask], np.int8)
                    batch = BatchView(np.array([view.observation], np.float32), masks, view.limits)
                    np.testing.assert_allclose(agent.act_batch(batch)[0], action, rtol=0, atol=tolerance)


def decided_by_prey(name, scenario):
    """Actions of an agent's prey on its views, (STEPS, 2), and the views."""
    prey, seen = agent_of(name, "Prey")(), list(views(scenario, "velocity", "prey"))
    prey.reset(1)
    return np.array([prey.act(view) for view in seen]), seen


@pytest.mark.parametrize("scenario", WITH_PREY)
@pytest.mark.parametrize("name", PREY)
def test_prey_does_what_it_did(name, scenario):
    with np.load(FILE) as recorded:
        actions = decided_by_prey(name, scenario)[0]
        np.testing.assert_allclose(actions, recorded[f"{name}-{scenario}-prey"], rtol=0, atol=1e-6)


@pytest.mark.parametrize("scenario", WITH_PREY)
def test_prey_that_acts_for_many_acts_bit_for_bit_as_for_one(scenario):
    """In views with hunters, and without any after a catch."""
    actions, seen = decided_by_prey("flee", scenario)
    observations = np.array([view.observation for view in seen], np.float32)
    observations = np.concatenate((observations, np.zeros_like(observations[:1])))
    commands = agent_of("flee", "Prey")().act_batch(PreyBatchView(observations, seen[0].limits))
    assert commands.tolist() == [*actions.tolist(), [0.0, 0.0]]


if __name__ == "__main__":
    actions = {f"{name}-{one}": decided(name, one)[0] for name in AGENTS for one in SCENARIOS}
    actions |= {f"{name}-{one}-prey": decided_by_prey(name, one)[0] for name in PREY for one in WITH_PREY}
    np.savez_compressed(FILE, **actions)
