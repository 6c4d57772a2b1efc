"""Frozen seat of `standard` after 808,321 decisions; training seed 3."""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """Agent with weights in the .npz file next to this one, made by examples/train_sides.py."""

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
