"""Chooses a destination in `tag` by a trained network; its prey is a trained network too.

PPO trained both sides of `tag` against each other, their earlier versions, flee and intercept
(examples/train_sides.py). The hunters are of seed 4, after 3 million decisions; the prey is of another run, seed 1,
after 5 million.
"""

from pathlib import Path

from catch_arena.agents.ladder.tag_prey_1_5080k import Prey
from catch_arena.training.pointer import PointerAgent

__all__ = ["Agent", "Prey"]


class Agent(PointerAgent):
    """Hunter with weights in the .npz file next to this one, made by examples/train_sides.py."""

    control = "velocity"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
