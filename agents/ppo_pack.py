"""Drives in `pack` by trained networks, as a hunter and as prey, which learned against each other.

PPO trained both sides in `pack`, against each other, their earlier versions, flee and together
(examples/train_sides.py): 8 million decisions of hunters, seed 2.
"""

from catch_arena.agents.ladder.pack_hunters_2_8027k import Agent
from catch_arena.agents.ladder.pack_prey_2_2748k import Prey

__all__ = ["Agent", "Prey"]
