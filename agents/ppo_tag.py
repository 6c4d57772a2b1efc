"""Chooses a destination in `tag` by a trained network; its prey is a trained network too.

PPO trained the hunters against flee (examples/train_sides.py): 2 million decisions, seed 1, from a network that prefers
what a script would take. The prey learned in another run, against hunters that learned too, their earlier versions and
intercept: seed 2, 5 million decisions.
"""

from pathlib import Path

from catch_arena.training.flat import FlatAgent
from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """Hunter with weights in the .npz file next to this one, made by examples/train_sides.py."""

    control = "velocity"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))


class Prey(FlatAgent):
    """Prey with weights in ppo_tag_prey.npz."""

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_name("ppo_tag_prey.npz"), "tag")
