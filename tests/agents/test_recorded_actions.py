"""Shipped agents act on recorded views as they always have.

`PYTHONPATH=tests python tests/agents/test_recorded_actions.py` writes tests/data/actions.npz. That is right only if an
agent is meant to play differently.
"""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import catch_arena
from catch_arena.batch_policy import BatchView
from catch_arena.layout import observation_size
from catch_arena.policy import Limits, View
from catch_arena.tournament.loading import shipped

FILE = Path(__file__).parents[1] / "data" / "actions.npz"
SCENARIOS = ("standard", "duel", "scarce", "crowd", "evasive", "fog", "haze", "pairs", "partners", "unequal", "tag")
AGENTS = [name for name in shipped() if name != "random"]
STEPS = 24


def agent_of(name):
    return import_module(f"catch_arena.agents.{name}").Agent


def views(scenario, control):
    """Yield the view of each hunter of a batch in turn, while all drive at random."""
    config = catch_arena.scenario(scenario, control=control, max_cycles=10 * STEPS)
    arena = catch_arena.VectorArena(config, 3)
    limits = [Limits.of(config, seat) for seat in range(config.hunters)]
    source = np.random.default_rng(7)
    observations, infos = arena.reset(seed=19)
    for step in range(STEPS):
        row, seat = step % 3, step % config.hunters
        seen = observations[row, seat, : observation_size(config)]
        yield View(seen.tolist(), infos["action_mask"][row, seat].tolist() if control == "target" else (), limits[seat])
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


if __name__ == "__main__":
    np.savez_compressed(FILE, **{f"{name}-{one}": decided(name, one)[0] for name in AGENTS for one in SCENARIOS})
