"""Chooses where to go by a trained network, and drives there as `patrol` does.

Trained by PPO in `standard`, against patrol, contested_by_time and contested, and for a part against its own past
(examples/train_ppo.py): 11 million decisions on two cores. It has not met the held-out opponents of the suite.
"""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """Its weights lie beside it; examples/train_ppo.py made them (docs/training.md)."""

    control = "velocity"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
