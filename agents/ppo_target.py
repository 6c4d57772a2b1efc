"""Chooses a target by a trained network; the arena's controller chases it.

It began with the weights of `ppo_destination`. PPO continued in `standard`, against patrol, contested_by_time,
contested, nearest and triage (examples/train_ppo.py --head rank). It has not met the held-out opponents of the suite.
"""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """Agent with weights in the .npz file next to this one, made by examples/train_ppo.py."""

    control = "target"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
