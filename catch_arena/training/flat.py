"""Agents that choose one of a few commands by a network over the observation (examples/train_sides.py)."""

import os
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.batch_policy import BatchView, PreyBatchView
from catch_arena.config import ArenaConfig, Control
from catch_arena.errors import ConfigError
from catch_arena.policy import PreyView, View
from catch_arena.training.columns_by_name import fit_observation
from catch_arena.training.networks import Mlp

COMMANDS: Final = np.array([(speed, turn) for speed in (0, 0.5, 1) for turn in (-1, -0.3, 0, 0.3, 1)], np.float32)
"""The commands: speed and turn rate as fractions of the limits, (15, 2)."""


class FlatAgent:
    """An agent, hunter or prey, that takes the command for which its network has the greatest output.

    Args:
        network: the network, or the file that holds it. It has an output for each of COMMANDS.
        trained: the scenario that it was trained in, or its config; `fit_observation` gives it that arena's columns.

    Raises:
        ConfigError: for a file that cannot be read, and for another number of outputs.
    """

    control: Final[Control] = "velocity"

    def __init__(self, network: Mlp | str | os.PathLike[str], trained: str | ArenaConfig) -> None:
        self.network: Final = network if isinstance(network, Mlp) else Mlp.load(network)
        self.trained: Final = trained
        outputs = len(self.network.layers[-1][1])
        if outputs != len(COMMANDS):
            raise ConfigError(f"the network must have {len(COMMANDS)} outputs, got {outputs}")

    def reset(self, seed: int) -> None:
        """Begin an episode; there is no state to reset."""

    def act(self, view: View | PreyView) -> tuple[float, float]:
        """Return speed and turn rate of one agent, as fractions of the limits."""
        speed, turn = self.act_batch(view).tolist()
        return speed, turn

    def act_batch(self, view: BatchView | PreyBatchView | View | PreyView) -> NDArray[np.float32]:
        """Return the speeds and turn rates of N agents, (N, 2), or of one, (2,)."""
        seen = fit_observation(view, self.trained, self.network.inputs)
        commands: NDArray[np.float32] = COMMANDS[self.network(seen).argmax(axis=-1)]
        return commands
