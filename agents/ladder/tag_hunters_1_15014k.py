"""Frozen hunters of `tag` after 15,013,695 decisions; training seed 1."""

from pathlib import Path

from catch_arena.training.flat import FlatAgent


class Agent(FlatAgent):
    """Agent with weights in the .npz file next to this one, made by examples/train_sides.py."""

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"), "tag")
