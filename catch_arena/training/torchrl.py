"""Learners as a TorchRL environment: a batch of arenas, each with a group of hunters that learn."""

from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from numpy.typing import NDArray
from tensordict import TensorDict, TensorDictBase
from torchrl.data import Binary, Bounded, Categorical, Composite, Unbounded
from torchrl.envs import EnvBase

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.training.learner_batch import LearnerBatch

GROUP = "hunters"
"""Key of the learners' tensors, (B, learners, ...) each."""


class _RefusesAutoReset(type(EnvBase)):  # type: ignore[misc]  # torchrl may be missing
    """Metaclass that refuses `auto_reset`: TorchRL's own removes it, and then never resets arenas that have ended."""

    def __call__(cls, *arguments: Any, auto_reset: bool = False, **settings: Any) -> Any:
        if auto_reset is not False:
            raise ConfigError(
                f"auto_reset must be False, because TorchRL resets ended arenas itself, got {auto_reset!r}"
            )
        return super().__call__(*arguments, **settings)


class TorchRLEnv(EnvBase, metaclass=_RefusesAutoReset):  # type: ignore[misc]  # torchrl may be missing
    """Environment of B arenas, with tensors for the learners and flags for the arenas.

    Learners have `("hunters", "observation")`, `("hunters", "action_mask")` (not under velocity control), `("hunters",
    "action")` and `("hunters", "reward")`; each arena has `done`, `terminated` and `truncated`. Ended arenas are reset
    only when TorchRL calls for it, so "next" has an episode's last observation. All tensors are copies.

    Args:
        scenario: a name or a config; target or velocity control.
        num_arenas: B, the number of arenas.
        settings: `LearnerBatch`'s other arguments, and fields of ArenaConfig.

    Raises:
        ConfigError: for an argument that is not allowed.
    """

    def __init__(self, scenario: str | ArenaConfig = "standard", num_arenas: int = 1, **settings: Any) -> None:
        self.batch = LearnerBatch(scenario, num_arenas, auto_reset=False, **settings)
        super().__init__(device=torch.device("cpu"), batch_size=torch.Size([self.batch.num_envs]))
        rows = (self.batch.num_envs, self.batch.learners)
        box, action = self.batch.observation_space, self.batch.action_space
        if isinstance(action, spaces.Dict):
            raise ConfigError("control must be target or velocity for TorchRL, got 'full'")
        low, high = (torch.as_tensor(bound).expand(*rows, -1) for bound in (box.low, box.high))
        seen = {"observation": Bounded(low=low, high=high, dtype=torch.float32)}
        act: Any = Bounded(low=-1.0, high=1.0, shape=(*rows, 2), dtype=torch.float32)
        if isinstance(action, spaces.Discrete):
            choices = int(action.n)
            seen["action_mask"] = Binary(choices, shape=(*rows, choices), dtype=torch.bool)
            act = Categorical(choices, shape=rows, dtype=torch.int64)
        self._has_masks = "action_mask" in seen
        self.observation_spec = Composite({GROUP: Composite(seen, shape=rows)}, shape=self.batch_size)
        self.action_spec = Composite({GROUP: Composite({"action": act}, shape=rows)}, shape=self.batch_size)
        self.reward_spec = Composite(
            {GROUP: Composite({"reward": Unbounded((*rows, 1), dtype=torch.float32)}, shape=rows)},
            shape=self.batch_size,
        )
        flag = Binary(1, shape=(rows[0], 1), dtype=torch.bool)
        self.done_spec = Composite(done=flag, terminated=flag.clone(), truncated=flag.clone(), shape=self.batch_size)
        self._seed: int | None = None

    def _reset(self, tensordict: TensorDictBase | None = None, **_: Any) -> TensorDictBase:
        arenas = None
        if tensordict is not None and "_reset" in tensordict.keys():  # noqa: SIM118 - a TensorDict has no other way
            arenas = tensordict["_reset"].reshape(-1).numpy()
        observations, masks = self.batch.reset(self._seed if arenas is None else None, arenas)
        self._seed = None
        return self._tensors(observations, masks)

    def _step(self, tensordict: TensorDictBase) -> TensorDictBase:
        actions = tensordict[GROUP, "action"].detach().numpy()
        step = self.batch.step(actions.reshape(self.batch.num_rows, *actions.shape[2:]))
        result = self._tensors(step.observations, step.masks)
        result[GROUP, "reward"] = self._grouped(step.rewards[:, None])
        ends = {"terminated": step.terminations, "truncated": step.truncations}
        for name, rows in {**ends, "done": step.terminations | step.truncations}.items():
            result[name] = torch.from_numpy(rows[:: self.batch.learners, None].copy())
        return result

    def _set_seed(self, seed: int | None) -> None:
        self._seed = seed

    def _grouped(self, rows: NDArray[np.generic]) -> torch.Tensor:
        return torch.from_numpy(rows).reshape(self.batch.num_envs, self.batch.learners, *rows.shape[1:])

    def _tensors(self, observations: NDArray[np.float32], masks: NDArray[np.bool_]) -> TensorDict:
        group = {"observation": self._grouped(observations)}
        if self._has_masks:
            group["action_mask"] = self._grouped(masks)
        rows = (self.batch.num_envs, self.batch.learners)
        return TensorDict({GROUP: TensorDict(group, batch_size=rows)}, batch_size=self.batch_size)
