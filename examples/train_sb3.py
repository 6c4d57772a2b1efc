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
    sys.exit(f"train_sb3: {error.name} is not installed: {install_hint('sb3')}")

from catch_arena.training import Mlp, SB3VecEnv

AGENT = '''"""Agent that examples/train_sb3.py has trained in `{scenario}`."""

from pathlib import Path

import numpy as np

from catch_arena.training import Mlp, fit_mask, fit_observation


class Agent:
    def __init__(self):
        self.network = Mlp.load(Path(__file__).with_suffix(".npz"))

    def reset(self, seed):
        """Begin an episode; there is no state to reset."""

    def act(self, view):
        values = self.network(fit_observation(view, "{scenario}"))
        return int(np.where(fit_mask(view, "{scenario}"), values, -np.inf).argmax())
'''

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--out", type=Path, default=Path("runs/sb3"), help="folder for agent.py and agent.npz")
parser.add_argument("--scenario", default="standard", help="scenario to learn in")
parser.add_argument("--steps", type=int, default=5_000_000, help="decisions of all learners together")
parser.add_argument("--seed", type=int, default=1, help="seed of the network and the arenas")
settings = parser.parse_args()
if settings.steps < 1:
    sys.exit(f"train_sb3: --steps must be at least 1, got {settings.steps}")
if (settings.out / "agent.py").exists():
    sys.exit(f"train_sb3: --out must be a new folder: an agent is kept in {settings.out}")
try:
    prepare_folder(settings.out)
    env = SB3VecEnv(settings.scenario, 64, opponents=["nearest", "contested", "patrol"], normalise=True)
except CatchArenaError as error:
    sys.exit(f"train_sb3: {error}")
model = MaskablePPO("MlpPolicy", env, n_steps=64, batch_size=1024, seed=settings.seed, verbose=1)
with suppress(KeyboardInterrupt):  # Ctrl-C ends training and keeps the weights
    model.learn(settings.steps)

network = Mlp.of_torch(model.policy.mlp_extractor.policy_net, model.policy.action_net, scale=env.batch.scale)
network.save(settings.out / "agent.npz")
(settings.out / "agent.py").write_text(AGENT.format(scenario=settings.scenario))
print(f"{settings.out}/agent.py: catch-arena check-agent {settings.out}/agent.py --scenario {settings.scenario}")
