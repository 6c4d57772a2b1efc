"""BenchMARL: IPPO over the parallel env, with masks in infos."""

import tempfile
from pathlib import Path
from typing import Any

from benchmarl.algorithms import IppoConfig
from benchmarl.environments.common import TaskClass
from benchmarl.environments.pettingzoo.common import PettingZooClass
from benchmarl.experiment import Experiment, ExperimentConfig
from benchmarl.models.mlp import MlpConfig
from torchrl.envs import PettingZooWrapper

import catch_arena


class CatchArenaTask(PettingZooClass):
    """Task with the methods that BenchMARL requires."""

    def get_env_fun(self, num_envs: int, continuous_actions: bool, seed: int | None, device: Any) -> Any:  # noqa: ARG002
        return lambda: PettingZooWrapper(
            catch_arena.parallel_env("duel", infos="mask", max_cycles=60), use_mask=False, seed=seed, device=device
        )

    def supports_continuous_actions(self) -> bool:
        return False

    def supports_discrete_actions(self) -> bool:
        return True

    def has_state(self) -> bool:
        return False

    def max_steps(self, env: Any) -> int:  # noqa: ARG002
        return 60


assert issubclass(CatchArenaTask, TaskClass)
experiment = ExperimentConfig.get_from_yaml()
experiment.loggers = []
experiment.evaluation = False
experiment.create_json = False
experiment.max_n_iters = 3
experiment.max_n_frames = None
experiment.on_policy_collected_frames_per_batch = 360
experiment.on_policy_n_envs_per_worker = 2
experiment.on_policy_minibatch_size = 120
experiment.on_policy_n_minibatch_iters = 2
with tempfile.TemporaryDirectory() as folder:
    experiment.save_folder = str(Path(folder))
    run = Experiment(
        task=CatchArenaTask("DUEL", {"max_cycles": 60}),
        algorithm_config=IppoConfig.get_from_yaml(),
        model_config=MlpConfig.get_from_yaml(),
        critic_model_config=MlpConfig.get_from_yaml(),
        seed=1,
        config=experiment,
    )
    run.run()
    assert run.total_frames >= 1080, run.total_frames
