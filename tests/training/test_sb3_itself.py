"""PPO of stable-baselines3 and MaskablePPO of sb3-contrib train on `SB3VecEnv` with opponents."""

import re
from pathlib import Path

import numpy as np
import pytest

from catch_arena.training import Mlp

pytestmark = pytest.mark.torch


def looks():
    """A callback that counts, after each step, the episodes that the time limit cut."""
    from stable_baselines3.common.callbacks import BaseCallback

    class Looks(BaseCallback):
        bootstrapped = 0

        def _on_step(self):
            for done, info in zip(self.locals["dones"], self.locals["infos"], strict=True):
                assert done == ("terminal_observation" in info)
                self.bootstrapped += bool(done and info["TimeLimit.truncated"])
            return True

    return Looks()


def test_maskable_ppo_learns_with_masks_and_the_value_of_what_the_time_limit_cut():
    from sb3_contrib import MaskablePPO
    from sb3_contrib.common.maskable.utils import is_masking_supported

    from catch_arena.training import SB3VecEnv

    env = SB3VecEnv("standard", 16, opponents=["nearest", "patrol"], normalise=True, max_cycles=60)
    assert is_masking_supported(env)
    model = MaskablePPO("MlpPolicy", env, n_steps=64, batch_size=512, n_epochs=4, seed=1)
    before = [weights.detach().clone() for weights in model.policy.parameters()]
    callback = looks()
    model.learn(16 * 64 * 6, callback=callback)
    assert callback.bootstrapped >= 16
    assert any((old != new).any() for old, new in zip(before, model.policy.parameters(), strict=True))
    assert model.rollout_buffer.observations.size == 64 * 16 * env.observation_space.shape[0]

    observations = env.reset()
    kept = observations.copy()
    actions, _ = model.predict(observations, action_masks=env.action_masks())
    assert env.action_masks()[np.arange(16), actions].all()
    env.step(actions)
    assert (observations == kept).all(), "a buffer that holds them would change with the env"


def test_ppo_learns_velocities_under_vec_normalize():
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecNormalize

    from catch_arena.training import SB3VecEnv

    env = VecNormalize(SB3VecEnv("duel", 8, control="velocity", opponents="patrol", max_cycles=60))
    PPO("MlpPolicy", env, n_steps=64, batch_size=256, n_epochs=2, seed=1).learn(8 * 64 * 2)


def test_the_network_of_the_docs_example_decides_in_numpy_as_in_torch(tmp_path, monkeypatch):
    page = (Path(__file__).parents[2] / "docs" / "tutorials" / "train_an_agent.md").read_text()
    (example,) = [code for code in re.findall(r"```python\n(.*?)```", page, re.DOTALL) if "sb3_contrib" in code]
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(example, names)  # noqa: S102 - ours
    network, env = Mlp.load("mine.npz"), names["env"]
    seen = env.reset()
    chosen, _ = names["model"].predict(seen, action_masks=env.action_masks(), deterministic=True)
    worth = np.where(env.action_masks(), network(seen * env.batch.scale), -np.inf)
    assert (worth.max(axis=1) - worth[np.arange(len(chosen)), chosen] < 1e-4).all()
