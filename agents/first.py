"""Chases the oldest target, as the original code does."""

from catch_arena.policy import View


class Agent:
    """The first in the alive list is the one that has waited longest."""

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: View) -> int:
        """The rank of the greatest age; of equal ages the nearer, which `max` meets first."""
        if not view.targets:
            return 0
        return max(view.targets, key=lambda target: target.age).rank
