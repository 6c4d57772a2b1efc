"""Saved states of arenas, and their check: the engine itself accepts every state without a check."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.engine import Engine
from catch_arena.equality import equal
from catch_arena.errors import ConfigError
from catch_arena.text import in_short


class SavedState(NamedTuple):  # noqa: PLW1641 - a tuple that holds arrays has no hash in any case
    """State of a batch of arenas, or of one of them. Two are equal if every bit is equal."""

    config: str
    """Digest of the arena's config."""
    num_envs: int | None
    """Number of arenas in the batch; None for a single row."""
    controls: NDArray[np.int8]
    """Controls of the hunters, as `VectorArena.set_controls` takes them: (B, H), or (H,) for a single row."""
    memory: NDArray[np.uint8]
    """Bytes of the engine's memory: see `Engine.save`."""
    finished: NDArray[np.uint8]
    """Records of finished episodes, of an engine with `auto_reset`; otherwise empty."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, SavedState) and equal(tuple(self), tuple(other))

    def __ne__(self, other: object) -> bool:
        return not self == other


def save_all(engine: Engine) -> SavedState:
    """R10.2: return the state of all arenas."""
    return SavedState(engine.config_digest, engine.num_arenas, engine.controls.copy(), *engine.save())


def save_row(engine: Engine, arena: int) -> SavedState:
    """R10.2: return the state of one arena, which any row of an engine of an equal config can take."""
    return SavedState(engine.config_digest, None, engine.controls[arena].copy(), *engine.save_row(arena))


def restore_all(engine: Engine, saved: SavedState) -> None:
    """Continue from a state that `require_saved` has checked."""
    engine.restore((saved.memory, saved.finished))
    engine.controls[:] = saved.controls


def restore_row(engine: Engine, arena: int, saved: SavedState) -> None:
    """Continue from a saved state in one arena."""
    engine.restore_row(arena, (saved.memory, saved.finished))
    engine.controls[arena] = saved.controls


def require_saved(saved: object, engine: Engine, *, alone: bool) -> None:
    """Check that an engine can continue from a saved state.

    Args:
        saved: the saved state.
        engine: the engine that is to continue from it.
        alone: whether it must be the state of one arena.

    Raises:
        ConfigError: for anything else, such as a state of another version of this package.
    """
    if not isinstance(saved, SavedState):
        raise ConfigError(f"saved must be a state that save() returned, got {in_short(saved)}")
    if saved.config != engine.config_digest:
        raise ConfigError(
            f"saved must come from an arena with an equal config (digest {engine.config_digest}), got {saved.config}"
        )
    num_envs = None if alone else engine.num_arenas
    if saved.num_envs != num_envs:
        wanted, got = ("a single row" if size is None else f"{size} arenas" for size in (num_envs, saved.num_envs))
        raise ConfigError(f"a saved state must be that of {wanted} here, got that of {got}")
    size, size_of_finished = engine.saved_sizes(alone=alone)
    _require_bytes(saved.memory, size)
    if size_of_finished and len(saved.finished):  # if one is empty, that engine has no auto_reset
        _require_bytes(saved.finished, size_of_finished)
    shape = engine.controls.shape[alone:]
    if np.shape(saved.controls) != shape:
        raise ConfigError(f"a saved state must have controls {shape}, got {np.shape(saved.controls)}")


def _require_bytes(given: object, size: int) -> None:
    if not isinstance(given, np.ndarray) or given.dtype != np.uint8 or given.shape != (size,):
        got = f"an array of {given.dtype} {given.shape}" if isinstance(given, np.ndarray) else type(given).__name__
        raise ConfigError(f"a saved state must be an array of uint8 ({size},), got {got}")
