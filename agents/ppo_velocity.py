"""Drives by a trained network alone: end to end, the velocities are its own.

It began as a copy of a network that chooses where to go (imitation, DAgger), and went on by PPO in `standard`, against
patrol, contested_by_time and contested (examples/train_ppo.py --head velocity). It has not met the held-out opponents.
"""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """Its weights lie beside it; examples/train_ppo.py made them (docs/training.md)."""

    control = "velocity"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
