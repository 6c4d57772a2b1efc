"""Chases the oldest target, as the original code does."""

from catch_arena.policy import View


class Agent:
    """Agent that chases the first target of the alive list, which has waited longest."""

    def reset(self, seed: int) -> None:
        """Do nothing: the agent keeps no state."""

    def act(self, view: View) -> int:
        """Return the rank of the oldest target, or 0 without targets; of equal ages `max` takes the nearer."""
        if not view.targets:
            return 0
        return max(view.targets, key=lambda target: target.age).rank
