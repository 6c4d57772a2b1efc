"""Drives with velocities that come directly from a trained network, end to end.

It began as a copy of a network that chooses a destination (imitation, DAgger). PPO continued in `standard`, against
patrol, contested_by_time and contested (examples/train_ppo.py --head velocity). It has not met the held-out opponents.
"""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """Agent with weights in the .npz file next to this one, made by examples/train_ppo.py."""

    control = "velocity"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
