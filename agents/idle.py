"""Does nothing: the baseline that every other agent must beat."""

from catch_arena.policy import View


class Agent:
    """Agent that holds its place."""

    def reset(self, seed: int) -> None:
        """Do nothing: the agent keeps no state."""

    def act(self, view: View) -> int:
        """Return 0, which is hold (R4.1)."""
        del view
        return 0
