"""Observations for a network in an arena of another width than its training arena, with columns matched by name."""

from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.batch_policy import BatchView, ManyViews, PreyBatchView
from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.layout import column_names, groups, prey_groups
from catch_arena.policy import AnyLimits, Limits, PreyView, View
from catch_arena.scenarios import scenario
from catch_arena.text import shortened

_FIRST_COLUMNS: Final = (
    "x y heading_cos heading_sin linear_velocity angular_velocity time_left score distance_integral bearing_integral "
    "forward left present age active score_difference mate times_caught alive"
)
"""Names of the columns that the networks in agents/ were trained with, without the ranks."""

_config_of: Final = lru_cache(maxsize=64)(scenario)  # a scenario is checked again in each call


def fit_observation(
    view: View | BatchView | PreyView | PreyBatchView, trained: str | ArenaConfig, inputs: int | None = None
) -> NDArray[np.float32]:
    """Return an observation with the columns of the arena that a network was trained in.

    Each column has the view's value of the same name, so the nearest targets and rivals are kept, and for prey the
    nearest hunters and other prey. Columns that the view does not have are 0, as for absent targets. Values are not
    rescaled: in a larger arena they may be larger than any that the network was trained with.

    Args:
        view: the view of one hunter or prey, or of many (...).
        trained: the scenario, or the config, that the network was trained in.
        inputs: the network's width. If it is not that of `trained`, columns newer than the networks in agents/ are
            left out.

    Returns:
        the observation: (D,) for one, (..., D) for many; D is the width of `trained`, for prey that of prey's view.

    Raises:
        ConfigError: for an unknown scenario, and for one without prey if the view is of prey.
    """
    given = view.observations if isinstance(view, ManyViews) else view.observation
    values = np.asarray(given, dtype=np.float32)
    zero = np.zeros((*values.shape[:-1], 1), dtype=np.float32)
    found: NDArray[np.float32] = np.concatenate((values, zero), axis=-1)[..., _places(view.limits, trained, inputs)]
    return found


def fit_mask(view: View | BatchView, trained: str | ArenaConfig) -> NDArray[np.bool_]:
    """Return the legal choices among those of a network; every choice that this mask allows is legal in the view.

    A rank that the view does not have is not legal.

    Args:
        view: the view of one hunter, or of many (...).
        trained: see `fit_observation`.

    Returns:
        the mask: (K + 1,) for one hunter, (..., K + 1) for many; K is the number of targets seen in `trained`. Under
        velocity control, which has no choices, its last dimension is 0.

    Raises:
        ConfigError: for an unknown scenario.
    """
    here = np.asarray(view.masks if isinstance(view, BatchView) else view.mask, dtype=np.bool_)
    if not here.shape[-1]:
        return here
    choices = 1 + _config_of(trained).targets_seen
    found = np.zeros((*here.shape[:-1], choices), dtype=np.bool_)
    found[..., : here.shape[-1]] = here[..., :choices]
    return found


@lru_cache(maxsize=64)
def _places(seen: AnyLimits, trained: str | ArenaConfig, inputs: int | None) -> NDArray[np.int64]:
    """Return the index of each column of `trained` in an observation, (D,); its width if it has no such column."""
    config, hunts = _config_of(trained), isinstance(seen, Limits)
    if not hunts and not config.prey:
        raise ConfigError(f"trained must be a scenario with prey for a view of prey, got {shortened(trained)}")
    names, wanted = (column_names((groups if hunts else prey_groups)(arena)) for arena in (seen, config))
    if inputs not in (None, len(wanted)):
        wanted = tuple(name for name in wanted if name.rpartition(".")[2] in _FIRST_COLUMNS.split())
    place = {name: number for number, name in enumerate(names)}
    return np.array([place.get(name, len(names)) for name in wanted], dtype=np.int64)
