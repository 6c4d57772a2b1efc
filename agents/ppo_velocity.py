"""Trained end to end: a network gives the velocities themselves."""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """Its weights lie beside it; scripts/train_ppo.py made them (docs/training.md)."""

    control = "velocity"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
