"""Chooses a destination by a trained network that learned to search a large arena, with a view of 1.5 m.

PPO trained it in `haze`, against patrol, triage and its earlier versions (examples/train_sides.py): one million
decisions, seed 1. It has no memory, and it has not met the held-out opponents.
"""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """Agent with weights in the .npz file next to this one, made by examples/train_sides.py."""

    control = "velocity"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
