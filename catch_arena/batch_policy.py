"""Agents that act for many hunters at once: the named view of a batch, and what such an agent is."""

from functools import cached_property
from typing import Any, Final, Protocol, runtime_checkable

from catch_arena.errors import ConfigError, require_type
from catch_arena.layout import SelfFeatures
from catch_arena.policy import Limits, first_rival_column, numbers_seen, rival_features, target_features
from catch_arena.text import in_short

TYPE_CHECKING = False  # an agent that does not use NumPy need not load it
if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_OWN: Final = len(SelfFeatures._fields)


class BatchView:
    """Many observations under names: `view.own.x`, `view.targets.forward`, `view.rivals.present`. Nothing is copied.

    Args:
        observations: (..., D), R7.1's layout.
        masks: (..., K + 1), R7.2's masks.
        limits: what each of these hunters can do, and what the arena is.
    """

    def __init__(self, observations: "NDArray[np.float32]", masks: "NDArray[np.int8]", limits: Limits) -> None:
        require_type("limits", limits, Limits, "Limits.of(config)")
        size = numbers_seen(limits)
        if tuple(getattr(observations, "shape", ())[-1:]) != (size,):
            raise ConfigError(
                f"observations must be an array whose last axis has {size} numbers, got {in_short(observations)}"
            )
        self.observations = observations
        """As they were given, for policies that learn."""
        self.masks = masks
        """1 where a choice is legal; `masks[..., 0]`, hold, always is."""
        self.limits = limits

    @cached_property
    def own(self) -> Any:  # the tables' fields, which are typed as those of one hunter
        """What each hunter knows of itself: `layout.SelfFeatures` of arrays (...)."""
        columns: Any = (self.observations[..., column] for column in range(_OWN))
        return SelfFeatures(*columns)

    @cached_property
    def targets(self) -> Any:
        """The targets of each, nearest first: `layout.TargetFeatures` (or MovingTargetFeatures) of arrays (..., K);
        zeros where `present` is 0.
        """
        return self._seen(target_features(self.limits), _OWN, self.limits.targets_seen)

    @cached_property
    def rivals(self) -> Any:
        """The rivals of each, nearest first: `layout.RivalFeatures` (or TeamRivalFeatures) of arrays (..., R); zeros
        where `present` is 0.
        """
        return self._seen(rival_features(self.limits), first_rival_column(self.limits), self.limits.hunters_seen)

    def _seen(self, features: Any, first: int, ranks: int) -> Any:
        count = len(features._fields)
        table = self.observations[..., first : first + ranks * count]
        return features(*(table[..., column::count] for column in range(count)))

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
