"""stable-baselines3's PPO and sb3-contrib's MaskablePPO over `SB3VecEnv`, with opponents in the batch."""

import contextlib
import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import torch
from sb3_contrib import MaskablePPO
from sb3_contrib.common.maskable.utils import is_masking_supported
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

from catch_arena.errors import ConfigError
from catch_arena.training import Mlp, SB3VecEnv


class Looks(BaseCallback):
    """What stable-baselines3 has in its hands after each step."""

    bootstrapped = 0

    def _on_step(self) -> bool:
        for done, info in zip(self.locals["dones"], self.locals["infos"], strict=True):
            assert done == ("terminal_observation" in info)
            self.bootstrapped += bool(done and info["TimeLimit.truncated"])
        return True


torch.set_num_threads(1)
with contextlib.suppress(ConfigError):  # stable-baselines3 never resets a row itself
    SB3VecEnv("duel", 2, auto_reset=False)
    raise AssertionError("an env whose rows stand still was made")
masked = SB3VecEnv("standard", 16, opponents=["nearest", "patrol"], normalise=True, max_cycles=60)
assert is_masking_supported(masked)
model = MaskablePPO("MlpPolicy", masked, n_steps=64, batch_size=512, n_epochs=4, seed=1)
before = [weights.detach().clone() for weights in model.policy.parameters()]
looks = Looks()
model.learn(16 * 64 * 6, callback=looks)
assert looks.bootstrapped >= 16
assert any((old != new).any() for old, new in zip(before, model.policy.parameters(), strict=True))

# the buffer holds what was seen, though the env has moved on
buffer = model.rollout_buffer
assert buffer.observations.size == 64 * 16 * masked.observation_space.shape[0]
observations = masked.reset()
kept = observations.copy()
actions, _ = model.predict(observations, action_masks=masked.action_masks())
assert masked.action_masks()[np.arange(16), actions].all()
masked.step(actions)
assert (observations == kept).all()

drives = VecNormalize(VecMonitor(SB3VecEnv("duel", 8, control="velocity", opponents="patrol", max_cycles=60)))
PPO("MlpPolicy", drives, n_steps=64, batch_size=256, n_epochs=2, seed=1).learn(8 * 64 * 2)
print("mean return", round(float(np.mean([episode["r"] for episode in model.ep_info_buffer])), 2))

# the page's own example, and that the network in NumPy decides as the one in torch
page = (Path(__file__).parents[3] / "docs" / "training.md").read_text()
(example,) = [code for code in re.findall(r"```python\n(.*?)```", page, re.DOTALL) if "sb3_contrib" in code]
with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
    names: dict[str, Any] = {}
    exec(example, names)  # noqa: S102 - ours
    network, env = Mlp.load("mine.npz"), names["env"]
seen = env.reset()
chosen, _ = names["model"].predict(seen, action_masks=env.action_masks(), deterministic=True)
worth = np.where(env.action_masks(), network(seen * env.batch.scale), -np.inf)
rows = np.arange(len(chosen))
assert (worth.max(axis=1) - worth[rows, chosen] < 1e-4).all()
