"""Chooses anew in every step among all that is legal."""

from random import Random

from catch_arena.policy import PreyView, View


class Agent:
    """Its choices follow from its own seed alone."""

    def reset(self, seed: int) -> None:
        """Begin the agent's own stream."""
        self.random = Random(seed)

    def act(self, view: View) -> int:
        """Hold, or any target in view, all with the same chance."""
        return self.random.choice([choice for choice, legal in enumerate(view.mask) if legal])


class Prey:
    """Drives about, anywhere."""

    def reset(self, seed: int) -> None:
        """Begin its own stream."""
        self.random = Random(seed)

    def act(self, view: PreyView) -> tuple[float, float]:
        """Any legal command, backwards only where that is allowed."""
        return self.random.uniform(-1.0 if view.limits.min_speed_mps else 0.0, 1.0), self.random.uniform(-1.0, 1.0)
