"""Frozen prey of `pack` after 2,747,674 decisions; training seed 2."""

from pathlib import Path

from catch_arena.agents.ladder.pack_hunters_2_8027k import Agent
from catch_arena.training.flat import FlatAgent

__all__ = ["Agent", "Prey"]


class Prey(FlatAgent):
    """Agent with weights in the .npz file next to this one, made by examples/train_sides.py."""

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"), "pack")
