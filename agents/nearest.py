"""Chases the nearest target, as the original text asks."""

from typing import Any

from catch_arena.batch_policy import BatchView
from catch_arena.policy import View


class Agent:
    """Agent that always chooses rank 1, since targets are ranked by distance."""

    def reset(self, seed: int) -> None:
        """Do nothing: the agent keeps no state."""

    def act(self, view: View) -> int:
        """Return 1 if there is a target, else 0 (hold)."""
        return int(choose(view.mask))

    def act_batch(self, view: BatchView) -> Any:
        """Return the choices of N hunters, (N,); `act` makes the same choice for one."""
        return choose(view.masks.T)


def choose(mask: Any) -> Any:
    """Return rank 1 if it is legal, else 0 (hold): the mask's number for rank 1. Masks of N hunters are (K + 1, N)."""
    return mask[1]
