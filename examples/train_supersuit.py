"""SuperSuit: the wrappers that can work with the env, and stable-baselines3's PPO over its vector env."""

import numpy as np
import supersuit
import torch
from stable_baselines3 import PPO

import catch_arena

torch.set_num_threads(1)


def play(env: object) -> int:
    """Play one episode of a parallel env with random actions; return the number of steps."""
    env.reset(seed=3)
    steps = 0
    while env.agents:
        env.step({agent: env.action_space(agent).sample() for agent in env.agents})
        steps += 1
    return steps


def agent_by_agent(env: object) -> int:
    """Play one episode of an AEC env with random actions; return the number of turns."""
    env.reset(seed=3)
    turns = 0
    for agent in env.agent_iter():
        *_, terminated, truncated, _ = env.last()
        env.step(None if terminated or truncated else env.action_space(agent).sample())
        turns += 1
    return turns


PLAIN = ["agent_indicator_v0", "flatten_v0", "nan_random_v0", "pad_action_space_v0", "pad_observations_v0"]
WRAPPERS = {
    **{name: getattr(supersuit, name) for name in PLAIN},
    "clip_reward_v0": lambda env: supersuit.clip_reward_v0(env, -1, 1),
    "delay_observations_v0": lambda env: supersuit.delay_observations_v0(env, 2),
    "dtype_v0": lambda env: supersuit.dtype_v0(env, np.float64),
    "frame_skip_v0": lambda env: supersuit.frame_skip_v0(env, 3),
    "frame_stack_v1": lambda env: supersuit.frame_stack_v1(env, 3),
    "max_observation_v0": lambda env: supersuit.max_observation_v0(env, 2),
    "nan_noop_v0": lambda env: supersuit.nan_noop_v0(env, 0),
    "normalize_obs_v0": lambda env: supersuit.normalize_obs_v0(env, env_min=0, env_max=1),
    "observation_lambda_v0": lambda env: supersuit.observation_lambda_v0(env, lambda seen, _space: seen * 0.5),
    "reshape_v0": lambda env: supersuit.reshape_v0(env, (*env.observation_space("hunter_0").shape, 1)),
    "reward_lambda_v0": lambda env: supersuit.reward_lambda_v0(env, lambda reward: reward - 0.01),
    "scale_actions_v0": lambda env: supersuit.scale_actions_v0(env, 0.5),
    "sticky_actions_v0": lambda env: supersuit.sticky_actions_v0(env, 0.25),
}
DRIVEN = {
    "clip_actions_v0": supersuit.clip_actions_v0,
    "scale_actions_v0": WRAPPERS.pop("scale_actions_v0"),
    "nan_zeros_v0": supersuit.nan_zeros_v0,
}

failed = {}
for name, wrap in {**WRAPPERS, **{f"{name} (velocity)": wrap for name, wrap in DRIVEN.items()}}.items():
    control = "velocity" if "velocity" in name else "target"
    for make, run in ((catch_arena.parallel_env, play), (catch_arena.env, agent_by_agent)):
        try:
            assert run(wrap(make(max_cycles=12, control=control))) >= 4
        except Exception as error:  # noqa: BLE001 - all failures are named together
            failed[f"{name}, {make.__name__}"] = f"{type(error).__name__}: {error}"
for infos in ("full", "mask", "none"):
    assert play(supersuit.black_death_v3(catch_arena.parallel_env("dropout", max_cycles=12, infos=infos))) >= 4
assert play(supersuit.frame_skip_v0(supersuit.black_death_v3(catch_arena.parallel_env("dropout", max_cycles=12)), 2))
print("\n".join(f"{name}: {error}" for name, error in failed.items()) or "every wrapper plays")

env = supersuit.pettingzoo_env_to_vec_env_v1(catch_arena.parallel_env("standard", max_cycles=60))
env = supersuit.concat_vec_envs_v1(env, 2, num_cpus=0, base_class="stable_baselines3")
# without a seed: SuperSuit's vector env has no seed()
PPO("MlpPolicy", env, n_steps=64, batch_size=128, n_epochs=2).learn(8 * 64 * 3)
assert not failed
