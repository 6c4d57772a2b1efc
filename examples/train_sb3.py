"""stable-baselines3: MaskablePPO of sb3-contrib, and an agent file that needs neither it nor torch."""

import argparse
import sys
from contextlib import suppress
from pathlib import Path

from catch_arena import CatchArenaError
from catch_arena.errors import install_hint
from catch_arena.files import prepare_folder

try:
    from sb3_contrib import MaskablePPO
except ModuleNotFoundError as error:
    sys.exit(f"train_sb3: it needs {error.name}, which is not installed: {install_hint('sb3')}")

from catch_arena.training import Mlp, SB3VecEnv

AGENT = '''"""Plays what examples/train_sb3.py has learned in `{scenario}`."""

from pathlib import Path

import numpy as np

from catch_arena.training import Mlp, fit_mask, fit_observation


class Agent:
    def __init__(self):
        self.network = Mlp.load(Path(__file__).with_suffix(".npz"))

    def reset(self, seed):
        """Nothing to forget."""

    def act(self, view):
        values = self.network(fit_observation(view, "{scenario}"))
        return int(np.where(fit_mask(view, "{scenario}"), values, -np.inf).argmax())
'''

said = argparse.ArgumentParser(description=__doc__)
said.add_argument("--out", type=Path, default=Path("runs/sb3"), help="where agent.py and agent.npz are written")
said.add_argument("--scenario", default="standard")
said.add_argument("--steps", type=int, default=5_000_000, help="of all learners together")
said.add_argument("--seed", type=int, default=1)
given = said.parse_args()
if given.steps < 1:
    sys.exit(f"train_sb3: --steps must be at least 1, got {given.steps}")
if (given.out / "agent.py").exists():
    sys.exit(f"train_sb3: --out must be a new folder: an agent is kept in {given.out}")
try:
    prepare_folder(given.out)
    env = SB3VecEnv(given.scenario, 64, opponents=["nearest", "contested", "patrol"], normalise=True)
except CatchArenaError as error:
    sys.exit(f"train_sb3: {error}")
model = MaskablePPO("MlpPolicy", env, n_steps=64, batch_size=1024, seed=given.seed, verbose=1)
with suppress(KeyboardInterrupt):  # Ctrl-C ends training and keeps the weights
    model.learn(given.steps)

network = Mlp.of_torch(model.policy.mlp_extractor.policy_net, model.policy.action_net, scale=env.batch.scale)
network.save(given.out / "agent.npz")
(given.out / "agent.py").write_text(AGENT.format(scenario=given.scenario))
print(f"{given.out}/agent.py: try catch-arena check-agent {given.out}/agent.py --scenario {given.scenario}")
