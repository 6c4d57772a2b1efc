"""Chases the nearest target that no rival is nearer to."""

from typing import Any

from catch_arena.batch_policy import BatchView
from catch_arena.policy import SeenHunter, SeenTarget, View


class Agent:
    """Counts distance only; `contested_by_time` counts the turn as well."""

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: View) -> int:
        """The first target that is its own; where all belong to rivals, the one where it is least behind."""
        choice, least = 0, float("inf")
        for target in view.targets:
            behind = target.distance - nearest_rival_m(view.rivals, target)
            if behind <= 0.0:
                return target.rank
            if behind < least:
                choice, least = target.rank, behind
        return choice

    def act_batch(self, view: BatchView) -> Any:
        """The same for N hunters: (N,)."""
        from catch_arena.training.scripted import contested  # a match must not wait for the compiler

        return contested(view)


def nearest_rival_m(rivals: tuple[SeenHunter, ...], target: SeenTarget) -> float:
    """The distance [m] between a target and the rival nearest to it; infinite where no rival is in view."""
    return min((rival.distance_to(target) for rival in rivals), default=float("inf"))
