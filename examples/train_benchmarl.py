"""BenchMARL: IPPO over the parallel env; where there is prey, hunters and prey learn against each other."""

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


ROLLOUTS, CYCLES = 3, 60  # in each scenario, and steps in a match: enough to try it, not to learn much
experiment = ExperimentConfig.get_from_yaml()
experiment.loggers = []
experiment.evaluation = False
experiment.create_json = False
experiment.max_n_iters = ROLLOUTS
experiment.max_n_frames = None
experiment.on_policy_collected_frames_per_batch = 6 * CYCLES
experiment.on_policy_n_envs_per_worker = 2
experiment.on_policy_minibatch_size = 2 * CYCLES
experiment.on_policy_n_minibatch_iters = 2
for scenario in ("tag", "pack", "partners"):
    with tempfile.TemporaryDirectory() as folder:
        experiment.save_folder = folder
        run = Experiment(
            task=CatchArenaTask(scenario.upper(), {"scenario": scenario, "max_cycles": CYCLES}),
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
