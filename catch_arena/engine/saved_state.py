"""Saved states of arenas."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.equality import equal
from catch_arena.errors import ConfigError


class SavedState(NamedTuple):  # noqa: PLW1641 - a tuple that holds arrays has no hash in any case
    """State of a batch of arenas, or of one of them. Two are equal if every bit is equal."""

    config: str
    """Digest of the arena's config."""
    num_envs: int | None
    """Number of arenas in the batch; None for a single row."""
    controls: NDArray[np.int8]
    """Controls of the hunters, as `VectorArena.set_controls` takes them: (B, H), or (H,) for a single row."""
    memory: NDArray[np.uint8]
    """Bytes of the engine's memory."""
    finished: NDArray[np.uint8]
    """Records of finished episodes, of an engine with `auto_reset`; otherwise empty."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, SavedState) and equal(tuple(self), tuple(other))

    def __ne__(self, other: object) -> bool:
        return not self == other


def require_bytes(given: object, size: int) -> None:
    """Raise ConfigError unless a part of a saved state is an array of that many bytes."""
    if not isinstance(given, np.ndarray) or given.dtype != np.uint8 or given.shape != (size,):
        got = f"an array of {given.dtype} {given.shape}" if isinstance(given, np.ndarray) else type(given).__name__
        raise ConfigError(f"a saved state must be an array of uint8 ({size},), got {got}")
