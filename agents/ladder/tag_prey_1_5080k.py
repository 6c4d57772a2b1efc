"""Frozen prey of `tag` after 5,080,098 decisions; training seed 1."""

from pathlib import Path

from catch_arena.agents.ladder.tag_hunters_1_15014k import Agent
from catch_arena.training.flat import FlatAgent

__all__ = ["Agent", "Prey"]


class Prey(FlatAgent):
    """Agent with weights in the .npz file next to this one, made by examples/train_sides.py."""

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"), "tag")
