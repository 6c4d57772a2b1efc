"""Agents that act for many hunters at once: the named view of a batch, and what such an agent is."""

from functools import cached_property
from typing import Any, Protocol, runtime_checkable

from catch_arena.layout import (
    MOVING_TARGET_COLUMNS,
    RIVAL_COLUMNS,
    SELF_COLUMNS,
    TARGET_COLUMNS,
    MovingTargetFeatures,
    RivalFeatures,
    SelfFeatures,
    TargetFeatures,
)
from catch_arena.policy import Limits

TYPE_CHECKING = False  # an agent that does not use NumPy need not load it
if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Numbers = NDArray[np.float32]


class BatchView:
    """Many observations under names: `view.own.x`, `view.targets.forward`, `view.rivals.present`. Nothing is copied.

    Args:
        observations: (..., D), R7.1's layout.
        masks: (..., K + 1), R7.2's masks.
        limits: what each of these hunters can do, and what the arena is.
    """

    def __init__(self, observations: "Numbers", masks: "NDArray[np.int8]", limits: Limits) -> None:
        self.observations = observations
        """As they were given, for policies that learn."""
        self.masks = masks
        """1 where a choice is legal; `masks[..., 0]`, hold, always is."""
        self.limits = limits

    @cached_property
    def own(self) -> Any:  # the tables' fields, which are typed as those of one hunter
        """What each hunter knows of itself: `layout.SelfFeatures` of arrays (...)."""
        columns: Any = (self.observations[..., column] for column in range(len(SELF_COLUMNS)))
        return SelfFeatures(*columns)

    @cached_property
    def targets(self) -> Any:
        """The targets of each, nearest first: `layout.TargetFeatures` (or MovingTargetFeatures) of arrays (..., K);
        zeros where `present` is 0.
        """
        features, count = (
            (MovingTargetFeatures, len(MOVING_TARGET_COLUMNS))
            if self.limits.targets_move
            else (TargetFeatures, len(TARGET_COLUMNS))
        )
        return features(*self._columns(len(SELF_COLUMNS), self.limits.targets_seen, count))

    @cached_property
    def rivals(self) -> Any:
        """The rivals of each, nearest first: `layout.RivalFeatures` of arrays (..., R); zeros where `present` is 0."""
        targets = len(MOVING_TARGET_COLUMNS) if self.limits.targets_move else len(TARGET_COLUMNS)
        first = len(SELF_COLUMNS) + self.limits.targets_seen * targets
        return RivalFeatures(*self._columns(first, self.limits.hunters_seen, len(RIVAL_COLUMNS)))

    def _columns(self, first: int, ranks: int, count: int) -> Any:
        table = self.observations[..., first : first + ranks * count]
        return [table[..., column::count] for column in range(count)]

    def of(self, rows: Any) -> "BatchView":
        """The view of some of the hunters: of an index, or of a mask."""
        return BatchView(self.observations[rows], self.masks[rows], self.limits)


@runtime_checkable
class BatchPolicy(Protocol):
    """An agent that can act for many hunters in one call. It keeps nothing of a hunter from step to step: which hunters
    it is asked for changes with every episode.
    """

    def reset(self, seed: int) -> None:
        """Begin; once, for all hunters and episodes."""

    def act_batch(self, view: BatchView) -> Any:
        """The actions of N hunters: target: (N,) whole numbers; velocity: (N, 2) numbers in [-1, 1]; full:
        {"cmd_vel": (N, 2), "catch": (N,)}.
        """
