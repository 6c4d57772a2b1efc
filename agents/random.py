"""Chooses at random among all legal choices in every step."""

from random import Random

from catch_arena.policy import PreyView, View


class Agent:
    """Agent whose choices depend only on its seed and the legal choices."""

    def reset(self, seed: int) -> None:
        """Start the agent's random stream from the seed."""
        self.random = Random(seed)

    def act(self, view: View) -> int:
        """Return 0 (hold) or the rank of any target in view, all with the same probability."""
        return self.random.choice([choice for choice, legal in enumerate(view.mask) if legal])


class Prey:
    """Prey that drives at random."""

    def reset(self, seed: int) -> None:
        """Start the prey's random stream from the seed."""
        self.random = Random(seed)

    def act(self, view: PreyView) -> tuple[float, float]:
        """Return any legal command; backwards only if the limits allow it."""
        return self.random.uniform(-1.0 if view.limits.min_speed_mps else 0.0, 1.0), self.random.uniform(-1.0, 1.0)
