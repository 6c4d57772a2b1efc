"""Does nothing: the floor that all others must beat."""

from catch_arena.policy import View


class Agent:
    """Holds its place."""

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: View) -> int:
        """0 is hold (R4.1)."""
        del view
        return 0
