"""RLlib: PPO over the parallel env, sampled by two workers, for training that needs more than one machine."""

import ray
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.core.rl_module import MultiRLModuleSpec, RLModuleSpec
from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv
from ray.tune.registry import register_env

import catch_arena

ray.init(num_cpus=3, include_dashboard=False, log_to_driver=False, configure_logging=False)
register_env("catch_arena", lambda _: ParallelPettingZooEnv(catch_arena.parallel_env("standard", max_cycles=60)))
config = (
    PPOConfig()
    .environment("catch_arena", disable_env_checking=True)
    .env_runners(num_env_runners=2, num_envs_per_env_runner=1, rollout_fragment_length=60)
    .multi_agent(policies={"shared"}, policy_mapping_fn=lambda *_, **__: "shared")
    .rl_module(rl_module_spec=MultiRLModuleSpec(rl_module_specs={"shared": RLModuleSpec()}))
    .training(train_batch_size_per_learner=240, minibatch_size=120, num_epochs=2)
)
algorithm = config.build_algo()
try:
    for _ in range(2):
        result = algorithm.train()
    assert result["env_runners"]["num_env_steps_sampled_lifetime"] >= 240, result["env_runners"]
    assert result["learners"]["shared"]["num_module_steps_trained_lifetime"] > 0
    print("mean return", result["env_runners"].get("episode_return_mean"))
finally:
    algorithm.stop()
    ray.shutdown()
