"""stable-baselines3: PPO for a scenario, and an agent file that needs neither it nor torch.

One hunter learns against scripted agents. In a scenario with teams or prey all hunters learn, with one network;
`--prey-agent` plays the prey. Hunters that choose targets have masks, which need MaskablePPO of sb3-contrib.
"""

import argparse
import sys
from contextlib import suppress
from pathlib import Path

from catch_arena import CatchArenaError, scenario
from catch_arena.errors import install_hint
from catch_arena.files import prepare_folder

try:
    from sb3_contrib import MaskablePPO
    from stable_baselines3 import PPO
except ModuleNotFoundError as error:
    sys.exit(f"train_sb3: {error.name} is not installed: {install_hint('sb3')}")

from catch_arena.config import RewardWeights
from catch_arena.training import Mlp, SB3VecEnv

AGENT = '''"""Agent that examples/train_sb3.py has trained in `{scenario}`."""

from pathlib import Path

import numpy as np

from catch_arena.training import Mlp, fit_mask, fit_observation


class Agent:
    control = "{control}"

    def __init__(self):
        self.network = Mlp.load(Path(__file__).with_suffix(".npz"))

    def reset(self, seed):
        """Begin an episode; there is no state to reset."""

    def act(self, view):
        values = self.network(fit_observation(view, "{scenario}"))
        return {action}
'''

ACTIONS = {
    "target": 'int(np.where(fit_mask(view, "{scenario}"), values, -np.inf).argmax())',
    "velocity": "np.clip(values, -1, 1)",
}

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--out", type=Path, default=Path("runs/sb3"), help="folder for agent.py and agent.npz")
parser.add_argument("--scenario", default="standard", help="scenario to learn in")
parser.add_argument("--prey-agent", help="agent that plays prey; flee if none is named")
parser.add_argument("--steps", type=int, default=5_000_000, help="decisions of all learners together")
parser.add_argument("--seed", type=int, default=1, help="seed of the network and the arenas")
settings = parser.parse_args()
if settings.steps < 1:
    sys.exit(f"train_sb3: --steps must be at least 1, got {settings.steps}")
if (settings.out / "agent.py").exists():
    sys.exit(f"train_sb3: --out must be a new folder: an agent is kept in {settings.out}")
try:
    prepare_folder(settings.out)
    config = scenario(settings.scenario)
    more = {"opponents": ["nearest", "contested", "patrol"]}
    if config.teams is not None or config.prey:
        more = {"rewards": RewardWeights(progress=0.1)}  # catches alone are too rare at first
    env = SB3VecEnv(config, 64, prey_agent=settings.prey_agent, normalise=True, **more)
except CatchArenaError as error:
    sys.exit(f"train_sb3: {error}")
algorithm = MaskablePPO if config.control == "target" else PPO
model = algorithm("MlpPolicy", env, n_steps=64, batch_size=1024, seed=settings.seed, verbose=1)
with suppress(KeyboardInterrupt):  # Ctrl-C ends training and keeps the weights
    model.learn(settings.steps)

network = Mlp.of_torch(model.policy.mlp_extractor.policy_net, model.policy.action_net, scale=env.batch.scale)
network.save(settings.out / "agent.npz")
action = ACTIONS[config.control].format(scenario=settings.scenario)
(settings.out / "agent.py").write_text(AGENT.format(scenario=settings.scenario, control=config.control, action=action))
print(f"{settings.out}/agent.py: catch-arena check-agent {settings.out}/agent.py --scenario {settings.scenario}")
