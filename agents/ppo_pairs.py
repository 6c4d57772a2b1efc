"""Chooses a destination by a trained network that learned to play with a team-mate.

It began with weights from training in `standard`. PPO continued in `pairs`, with and against patrol,
contested_by_time, contested, triage and its earlier versions (examples/train_ppo.py). It has not met the
held-out opponents.
"""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """Agent with weights in the .npz file next to this one, made by examples/train_ppo.py."""

    control = "velocity"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
