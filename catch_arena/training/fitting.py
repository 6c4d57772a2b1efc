"""What a network sees in an arena of another width than that it was trained in: columns are taken by their names."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from catch_arena.batch_policy import BatchView
from catch_arena.config import ArenaConfig
from catch_arena.layout import SELF_COLUMNS
from catch_arena.policy import Limits, View, rival_features, target_features
from catch_arena.scenarios import scenario


def fit_observation(view: View | BatchView, trained: str | ArenaConfig) -> NDArray[np.float32]:
    """An observation as hunters have it in the arena that a network was trained in.

    The columns of that arena, in its order, each with the value that the view has under the same name: the nearest
    targets and rivals are those that are kept. What the view does not have is 0, as what is absent is anyhow. Values
    are not rescaled: in a larger arena they may be larger than any that the network has met.

    Args:
        view: of one hunter, or of many (...).
        trained: the scenario, or the config, that the network was trained in.

    Returns:
        (D,), of many (..., D), where D is the width of `trained`.

    Raises:
        ConfigError: for an unknown scenario.
    """
    given = view.observations if isinstance(view, BatchView) else view.observation
    values = np.asarray(given, dtype=np.float32)
    nothing = np.zeros((*values.shape[:-1], 1), dtype=np.float32)
    found: NDArray[np.float32] = np.concatenate((values, nothing), axis=-1)[..., _places(view.limits, _limits(trained))]
    return found


def fit_mask(view: View | BatchView, trained: str | ArenaConfig) -> NDArray[np.bool_]:
    """The legal choices among those that a network has: a rank that is not in view here is none, and so whatever is
    chosen with this mask is legal here.

    Args:
        view: of one hunter, or of many (...).
        trained: as of `fit_observation`.

    Returns:
        (K + 1,), of many (..., K + 1), where K is how many targets are seen in `trained`; under velocity control, where
        there are no choices, (0,).

    Raises:
        ConfigError: for an unknown scenario.
    """
    here = np.asarray(view.masks if isinstance(view, BatchView) else view.mask, dtype=np.bool_)
    if not here.shape[-1]:
        return here
    choices = 1 + _limits(trained).targets_seen
    found = np.zeros((*here.shape[:-1], choices), dtype=np.bool_)
    found[..., : here.shape[-1]] = here[..., :choices]
    return found


@lru_cache(maxsize=64)
def _limits(trained: str | ArenaConfig) -> Limits:
    return Limits.of(scenario(trained))


@lru_cache(maxsize=64)
def _places(seen: Limits, trained: Limits) -> NDArray[np.int64]:
    """(D,): where each column of `trained` stands in what is seen; behind its end where it does not."""
    names = _names(seen)
    place = {name: number for number, name in enumerate(names)}
    return np.array([place.get(name, len(names)) for name in _names(trained)], dtype=np.int64)


def _names(limits: Limits) -> tuple[str, ...]:
    """The names of `layout.columns`, from what a hunter knows of its arena."""
    targets, rivals = target_features(limits)._fields, rival_features(limits)._fields
    return (
        *SELF_COLUMNS,
        *(f"target_{rank}.{name}" for rank in range(1, limits.targets_seen + 1) for name in targets),
        *(f"rival_{rank}.{name}" for rank in range(1, limits.hunters_seen + 1) for name in rivals),
    )
