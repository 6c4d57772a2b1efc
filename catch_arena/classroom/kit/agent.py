"""A hunter that takes the nearest target that no rival is nearer to: change it."""

from catch_arena.policy import View


class Agent:
    """One hunter; `catch-arena docs agents` lists all that it sees and may do."""

    control = "target"  # or "velocity" or "full": the agent drives itself

    def reset(self, seed: int) -> None:
        """Begin a match. The seed is the agent's own."""

    def act(self, view: View) -> int:
        """Return the rank of a target, or 0 to hold."""
        for target in view.targets:
            distances = [rival.distance_to(target) for rival in view.rivals]
            if min(distances, default=99.0) > target.distance:
                return target.rank
        return 1 if view.targets else 0
