"""Drives in `pack` by trained networks, as a hunter and as prey, which learned against each other.

PPO trained both sides in `pack`, against each other, their earlier versions, flee and together
(examples/train_sides.py): hunters of 8 million decisions, seed 2, and prey of another run, seed 2, 5 million.
"""

from pathlib import Path

from catch_arena.agents.ladder.pack_hunters_2_8027k import Agent
from catch_arena.training.flat import FlatAgent

__all__ = ["Agent", "Prey"]


class Prey(FlatAgent):
    """Prey with weights in ppo_pack_prey.npz, made by examples/train_sides.py."""

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_name("ppo_pack_prey.npz"), "pack")
