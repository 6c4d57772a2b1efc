"""Gymnasium: its vector wrappers over `GymnasiumVectorEnv`."""

import gymnasium
import numpy as np
import torch
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers import vector as wrappers

from catch_arena.training import GymnasiumVectorEnv

WRAPPERS = {
    "ClipReward": lambda env: wrappers.ClipReward(env, -1, 1),
    "DictInfoToList": wrappers.DictInfoToList,
    "DtypeObservation": lambda env: wrappers.DtypeObservation(env, np.float64),
    "FlattenObservation": wrappers.FlattenObservation,
    "NormalizeReward": wrappers.NormalizeReward,
    "NumpyToTorch": wrappers.NumpyToTorch,
    "RecordEpisodeStatistics": wrappers.RecordEpisodeStatistics,
    "RescaleObservation": lambda env: wrappers.RescaleObservation(env, -1, 1),
    "ReshapeObservation": lambda env: wrappers.ReshapeObservation(env, (1, *env.single_observation_space.shape)),
    "TransformObservation": lambda env: wrappers.TransformObservation(env, lambda seen: seen * 0.5),
    "TransformReward": lambda env: wrappers.TransformReward(env, lambda reward: reward * 2),
    "VectorizeTransformReward": lambda env: wrappers.VectorizeTransformReward(
        env, gymnasium.wrappers.TransformReward, func=lambda reward: reward * 2
    ),
}
failed = {}
for auto_reset in (True, False):
    for name, wrap in WRAPPERS.items():
        if auto_reset and "Observation" in name:
            continue  # Gymnasium's wrappers of observations refuse SAME_STEP
        env = GymnasiumVectorEnv("standard", 3, opponents="nearest", auto_reset=auto_reset, max_cycles=5)
        assert (env.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP) == auto_reset
        try:
            env = wrap(env)
            env.reset(seed=1)
            for _ in range(12 if auto_reset else 5):
                actions = env.action_space.sample()
                env.step(torch.as_tensor(actions) if name == "NumpyToTorch" else actions)
        except Exception as error:  # noqa: BLE001 - all failures are named together
            failed[f"{name}, auto_reset={auto_reset}"] = f"{type(error).__name__}: {error}"
print("\n".join(f"{name}: {error}" for name, error in failed.items()) or "every wrapper plays")
assert not failed
