"""Chases the nearest target, as the original text asks."""

from typing import Any

from catch_arena.batch_policy import BatchView
from catch_arena.policy import View


class Agent:
    """Targets are ranked by distance, so its choice is always rank 1."""

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: View) -> int:
        """1 where that is legal, because there is a target; else 0 (hold)."""
        return 1 if view.mask[1] else 0

    def act_batch(self, view: BatchView) -> Any:
        """The same for N hunters: (N,)."""
        return view.masks[:, 1]
