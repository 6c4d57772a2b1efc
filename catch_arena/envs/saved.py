"""What envs ask of a saved state before they go on from it: the engine believes whatever it is given."""

import numpy as np
from numpy.typing import NDArray

from catch_arena.engine import Engine
from catch_arena.errors import ConfigError


def require_memory(engine: Engine, memory: object, *, alone: bool) -> NDArray[np.uint8]:
    """The memory of a saved state, as an engine of an equal config keeps it.

    Args:
        engine: that goes on from it.
        memory: what was saved.
        alone: whether it is that of one arena.

    Raises:
        ConfigError: for anything else, such as what another version of this package has kept.
    """
    sizes = engine.saved_sizes(alone=alone)
    if isinstance(memory, np.ndarray) and memory.dtype == np.uint8 and memory.shape in [(size,) for size in sizes]:
        return memory
    got = f"one of {memory.dtype} {memory.shape}" if isinstance(memory, np.ndarray) else type(memory).__name__
    raise ConfigError(f"a saved state must be an array of uint8 ({sizes[-1]},), got {got}")
