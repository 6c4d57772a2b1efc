"""Chooses a destination by a trained network, and drives there as `patrol` does.

Trained by PPO in `standard`, against patrol, contested_by_time and contested, and partly against its earlier
versions (examples/train_ppo.py): 11 million decisions on two cores. It has not met the held-out opponents of the suite.
"""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """Agent with weights in the .npz file next to this one, made by examples/train_ppo.py."""

    control = "velocity"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
