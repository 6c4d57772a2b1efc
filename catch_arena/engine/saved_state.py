"""Saved states of arenas."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from catch_arena.equality import EqualByBits


@dataclass(frozen=True, slots=True, eq=False)
class SavedState(EqualByBits):
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
