"""Learners as a `gymnasium.vector.VectorEnv`: each row is an environment, so that Gymnasium's vector wrappers work."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig, require_options
from catch_arena.errors import ConfigError
from catch_arena.plain import as_python
from catch_arena.training.learner_batch import LearnerBatch


class GymnasiumVectorEnv(VectorEnv[Any, Any, Any]):
    """Vector environment with a row for every learner of every arena.

    An ended episode is followed by the next one in the same step (SAME_STEP). With `auto_reset=False` (DISABLED) its
    rows stand still until `reset(options={"reset_mask": rows})` names them; Gymnasium's wrappers of observations
    support only this mode.

    `infos` has `action_mask` (N, K + 1) int8 (not under velocity control). If episodes ended, it has also `final_obs`
    (N, D) and `final_info`: the last mask and the episode's figures. For each entry, the entry of the same name with a
    leading `_` is the mask (N,) of the rows that have a value. All arrays are copies.

    Args:
        scenario: a name or a config.
        num_arenas: B, the number of arenas; the env has B * learners rows.
        settings: `LearnerBatch`'s other arguments, and fields of ArenaConfig.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 - Gymnasium's own form

    def __init__(self, scenario: str | ArenaConfig = "standard", num_arenas: int = 1, **settings: Any) -> None:
        self.batch = LearnerBatch(scenario, num_arenas, **settings)
        self._auto_reset = self.batch.arena.auto_reset
        mode = AutoresetMode.SAME_STEP if self._auto_reset else AutoresetMode.DISABLED
        self.metadata = {**type(self).metadata, "autoreset_mode": mode}
        self.num_envs = self.batch.num_rows
        self.single_observation_space = self.batch.observation_space
        self.single_action_space = self.batch.action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | NDArray[np.integer] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin all episodes, or those of `options["reset_mask"]`, (N,) bool.

        The mask must have all learners of an arena or none. If `seed` is a list, one for each row, only its first
        number is used, because the rows of an arena begin together.

        Returns:
            Observations (N, D) float32, and infos.

        Raises:
            ConfigError: for a mask, a seed or options that are not allowed.
        """
        require_options(options)
        first = as_python(seed)
        if isinstance(first, Sequence) and not isinstance(first, str | bytes):
            if len(first) != self.num_envs:
                raise ConfigError(f"seed must be one number, or one for each of {self.num_envs} rows, got {len(first)}")
            first = first[0]
        arenas = None
        if options is not None and "reset_mask" in options:
            rows = np.asarray(options["reset_mask"])
            if rows.shape != (self.num_envs,) or rows.dtype != np.bool_:
                raise ConfigError(
                    f"reset_mask must be {self.num_envs} booleans, got {rows.dtype} of the shape {rows.shape}"
                )
            together = rows.reshape(-1, self.batch.learners)
            arenas = together.any(axis=1)
            if (together.all(axis=1) != arenas).any():
                raise ConfigError("reset_mask must be equal for all learners of an arena, got True for some of them")
        observations, masks = self.batch.reset(first, arenas)
        return observations, self._with_rows(_masks(masks), np.ones(self.num_envs, np.bool_))

    def step(
        self, actions: Any
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """R1.4: play one step of every row.

        Args:
            actions: (N,) choices, (N, 2) velocities, or under full control {"cmd_vel": (N, 2), "catch": (N,)}.

        Returns:
            Observations (N, D) float32, rewards (N,) float64, terminations and truncations (N,) bool, and infos as the
            class describes them.

        Raises:
            ActionError: for an action that is not legal; nothing has moved then.
            AgentError: for an opponent that raised, or whose action is not legal; nothing has moved then.
            EpisodeError: before the first reset.
        """
        step = self.batch.step(actions)
        infos = self._with_rows(_masks(step.masks), np.ones(self.num_envs, np.bool_))
        if self._auto_reset and len(step.ended):
            over = np.zeros(self.num_envs, np.bool_)
            over[step.ended] = True
            figures: dict[str, Any] = {**step.figures, **_masks(step.final_masks)}
            final = {name: self._spread(table, step.ended) for name, table in figures.items()}
            last = self._spread(step.final_observations, step.ended)
            infos |= self._with_rows({"final_obs": last, "final_info": self._with_rows(final, over)}, over)
        return step.observations, step.rewards.astype(np.float64), step.terminations, step.truncations, infos

    @staticmethod
    def _with_rows(infos: dict[str, Any], rows: NDArray[np.bool_]) -> dict[str, Any]:
        return {**infos, **{f"_{name}": rows.copy() for name in infos}}

    def _spread(self, table: NDArray[Any], rows: NDArray[np.int64]) -> NDArray[Any]:
        whole = np.zeros((self.num_envs, *table.shape[1:]), table.dtype)
        whole[rows] = table
        return whole


def _masks(masks: NDArray[np.bool_]) -> dict[str, NDArray[np.int8]]:
    """Return the masks as int8, the type of Gymnasium's spaces, under `action_mask`; empty under velocity control."""
    return {"action_mask": masks.view(np.int8)} if masks.size else {}
