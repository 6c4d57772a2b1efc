"""Learners as a stable-baselines3 VecEnv: every learner of every arena is one environment."""

import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env.base_vec_env import VecEnv

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.training.learner_batch import LearnerBatch, LearnerStep


class SB3VecEnv(VecEnv):  # type: ignore[misc]  # stable-baselines3 may be missing
    """Environment for `PPO("MlpPolicy", env)`, and for sb3-contrib's `MaskablePPO`, which calls `action_masks`.

    If an episode ends, the row's info has `terminal_observation`, `terminal_mask`, `TimeLimit.truncated`, `score`,
    `rank` and `episode`. stable-baselines3 bootstraps values by `terminal_observation` and `TimeLimit.truncated`.
    `episode` has `r`, `l` and `t` as its Monitor writes them, with `score` and `rank`. All arrays are copies:
    stable-baselines3 reads an observation after the next step, when a shared array would have other values.

    Args:
        scenario: a name or a config; target or velocity control.
        num_arenas: B, the number of arenas; the env has B * learners rows.
        settings: `LearnerBatch`'s other arguments, and fields of ArenaConfig.

    Raises:
        ConfigError: for an argument that is not allowed.
    """

    def __init__(self, scenario: str | ArenaConfig = "standard", num_arenas: int = 1, **settings: Any) -> None:
        if not settings.get("auto_reset", True):
            raise ConfigError(f"auto_reset must be True for stable-baselines3, got {settings['auto_reset']!r}")
        self.batch = LearnerBatch(scenario, num_arenas, **settings)
        if isinstance(self.batch.action_space, spaces.Dict):
            raise ConfigError("control must be target or velocity for stable-baselines3, got 'full'")
        self.render_mode = None
        super().__init__(self.batch.num_rows, self.batch.observation_space, self.batch.action_space)
        self._actions: NDArray[Any] | None = None
        self._began = time.monotonic()

    def reset(self) -> NDArray[np.float32]:
        """Begin all episodes, with the first seed given to `seed`, and return observations (N, D) float32."""
        observations, _ = self.batch.reset(self._seeds[0])
        self._reset_seeds()
        self._reset_options()
        self.reset_infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        return observations

    def step_async(self, actions: NDArray[Any]) -> None:
        """Store the actions for `step_wait`."""
        self._actions = actions

    def step_wait(
        self,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """R1.4: play one step of every row.

        Returns:
            observations (N, D) and rewards (N,) float32, dones (N,) bool, and N infos.
        """
        step = self.batch.step(self._actions if self._actions is not None else [])
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        if len(step.ended):
            self._describe_ends(step, infos)
        return step.observations, step.rewards, step.terminations | step.truncations, infos

    def _describe_ends(self, step: LearnerStep, infos: list[dict[str, Any]]) -> None:
        took = round(time.monotonic() - self._began, 6)
        names = ("return", "length", "score", "rank")
        figures = zip(*(step.figures[name].tolist() for name in names), strict=True)
        cut = (step.truncations & ~step.terminations).tolist()
        for place, (row, (total, length, score, rank)) in enumerate(zip(step.ended.tolist(), figures, strict=True)):
            infos[row] = {
                "terminal_observation": step.final_observations[place],
                "terminal_mask": step.final_masks[place],
                "TimeLimit.truncated": cut[row],
                "score": int(score),
                "rank": int(rank),
                "episode": {"r": total, "l": int(length), "t": took, "score": int(score), "rank": int(rank)},
            }

    def close(self) -> None:
        """Do nothing: the batch holds nothing that must be released."""

    def action_masks(self) -> NDArray[np.bool_]:
        """Return the legal choices of every row: (N, K + 1)."""
        return self.batch.masks

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """Call a method once and return its result for each row; sb3-contrib calls `action_masks` in this way."""
        result = getattr(self, method_name)(*args, **kwargs)
        if method_name == "action_masks":
            return [result[row] for row in self._get_indices(indices)]
        return [result for _ in self._get_indices(indices)]

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute, which all rows share, once for each row."""
        if attr_name == "action_masks" and not isinstance(self.action_space, spaces.Discrete):
            raise AttributeError("velocity control has no action masks")
        value = getattr(self, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute, which all rows share."""
        if indices is not None:
            raise ConfigError(f"indices must be None, because all rows share their attributes, got {indices!r}")
        setattr(self, attr_name, value)

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Any = None) -> Sequence[bool]:
        """Return True for Monitor, whose figures every row has, and False for other wrappers, once for each row."""
        return [wrapper_class is Monitor for _ in self._get_indices(indices)]
