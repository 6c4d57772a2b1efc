"""BenchMARL: IPPO over the parallel env; where there is prey, hunters and prey learn against each other."""

import argparse
import tempfile
from typing import Any

from benchmarl.algorithms import IppoConfig
from benchmarl.environments.pettingzoo.common import PettingZooClass
from benchmarl.experiment import Experiment, ExperimentConfig
from benchmarl.models.mlp import MlpConfig
from torchrl.envs import PettingZooWrapper

import catch_arena
from catch_arena.config import RewardWeights


class CatchArenaTask(PettingZooClass):
    """Task with the methods that BenchMARL requires. Its config has the scenario, and fields of ArenaConfig."""

    def make(self) -> catch_arena.CatchArenaEnv:
        return catch_arena.parallel_env(infos="mask", rewards=RewardWeights(progress=0.1), **self.config)

    def get_env_fun(self, num_envs: int, continuous_actions: bool, seed: int | None, device: Any) -> Any:  # noqa: ARG002
        return lambda: PettingZooWrapper(self.make(), use_mask=False, seed=seed, device=device)

    def supports_continuous_actions(self) -> bool:
        return self.make().config.control == "velocity"

    def supports_discrete_actions(self) -> bool:
        return self.make().config.control == "target"


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--scenarios", default="tag,pack,partners", help="scenarios to learn in, one by one")
parser.add_argument("--iterations", type=int, default=3, help="number of rollouts in each of them")
parser.add_argument("--cycles", type=int, default=60, help="number of steps in a match")
settings = parser.parse_args()
experiment = ExperimentConfig.get_from_yaml()
experiment.loggers = []
experiment.evaluation = False
experiment.create_json = False
experiment.max_n_iters = settings.iterations
experiment.max_n_frames = None
experiment.on_policy_collected_frames_per_batch = 6 * settings.cycles
experiment.on_policy_n_envs_per_worker = 2
experiment.on_policy_minibatch_size = 2 * settings.cycles
experiment.on_policy_n_minibatch_iters = 2
for scenario in settings.scenarios.split(","):
    with tempfile.TemporaryDirectory() as folder:
        experiment.save_folder = folder
        run = Experiment(
            task=CatchArenaTask(scenario.upper(), {"scenario": scenario, "max_cycles": settings.cycles}),
            algorithm_config=IppoConfig.get_from_yaml(),
            model_config=MlpConfig.get_from_yaml(),
            critic_model_config=MlpConfig.get_from_yaml(),
            seed=1,
            config=experiment,
        )
        before = {side: [w.clone() for w in policy.parameters()] for side, policy in run.group_policies.items()}
        run.run()
    for side, policy in run.group_policies.items():
        learned = any((old != new).any() for old, new in zip(before[side], policy.parameters(), strict=True))
        assert learned, side
        print(f"{scenario}: {', '.join(run.group_map[side])} learned by the network {side}")
