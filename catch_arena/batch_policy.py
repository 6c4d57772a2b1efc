"""Named views of many hunters or prey, for agents that act for all of them in one call (docs/howto/training.md)."""

from functools import cached_property
from typing import Any

from catch_arena.errors import ConfigError, require_type
from catch_arena.layout import Group, groups, prey_groups
from catch_arena.policy import Limits, PreyLimits
from catch_arena.text import shortened

TYPE_CHECKING = False  # agents that do not use NumPy need not load it
if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class ManyViews:
    """Base of both views: many observations, and their groups of columns under names."""

    def __init__(self, observations: "NDArray[np.float32]", groups: tuple[Group, ...]) -> None:
        size = groups[-1].end
        if tuple(getattr(observations, "shape", ())[-1:]) != (size,):
            raise ConfigError(
                f"observations must be an array whose last axis has length {size}, got {shortened(observations)}"
            )
        self.observations = observations
        """Observations as they were given, for policies that learn."""
        self._groups = groups

    def _table(self, index: int) -> Any:
        """Return the columns of a group under the names of its table: arrays (...), or (..., ranks)."""
        group, count = self._groups[index], len(self._groups[index].table._fields)
        columns = self.observations[..., group.first : group.end]
        return group.table(
            *(columns[..., column::count] if group.kind else columns[..., column] for column in range(count))
        )


class BatchView(ManyViews):
    """Many observations under names: `view.own.x`, `view.targets.forward`, `view.rivals.present`. Nothing is copied.

    Args:
        observations: (..., D), in the layout of R7.1.
        masks: (..., K + 1), the masks of R7.2.
        limits: the abilities that these hunters share, and the arena's settings.
    """

    def __init__(self, observations: "NDArray[np.float32]", masks: "NDArray[np.int8]", limits: Limits) -> None:
        require_type("limits", limits, Limits, "Limits.of(config)")
        super().__init__(observations, groups(limits))
        self.masks = masks
        """Masks, 1 for each legal choice; `masks[..., 0]`, hold, is always legal."""
        self.limits = limits

    @cached_property
    def own(self) -> Any:  # the tables type their fields as those of one hunter
        """Data of each hunter about itself: `layout.SelfFeatures` of arrays (...)."""
        return self._table(0)

    @cached_property
    def targets(self) -> Any:
        """Targets of each hunter, nearest first: `layout.TargetFeatures` (or MovingTargetFeatures) of arrays (...,
        K); all zeros if `present` is 0.
        """
        return self._table(1)

    @cached_property
    def rivals(self) -> Any:
        """Rivals of each hunter, nearest first: `layout.RivalFeatures` (or TeamRivalFeatures) of arrays (..., R);
        all zeros if `present` is 0.
        """
        return self._table(2)


class PreyBatchView(ManyViews):
    """Many observations of prey under names: `view.own.x`, `view.hunters.forward`. Nothing is copied.

    Args:
        observations: (..., E), in the layout of R12.4.
        limits: the abilities that all prey shares, and the arena's settings.
    """

    def __init__(self, observations: "NDArray[np.float32]", limits: PreyLimits) -> None:
        require_type("limits", limits, PreyLimits, "PreyLimits.of(config)")
        super().__init__(observations, prey_groups(limits))
        self.limits = limits

    @cached_property
    def own(self) -> Any:
        """Data of each prey about itself: `layout.PreySelfFeatures` of arrays (...)."""
        return self._table(0)

    @cached_property
    def hunters(self) -> Any:
        """Hunters in view of each prey, nearest first: `layout.BodyFeatures` of arrays (..., K); all zeros if
        `present` is 0.
        """
        return self._table(1)

    @cached_property
    def others(self) -> Any:
        """Other prey in view of each prey, nearest first: `layout.OtherPreyFeatures` of arrays (..., P); all zeros if
        `present` is 0.
        """
        return self._table(2)
