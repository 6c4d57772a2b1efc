"""Chooses where to go beside a team-mate, by a trained network.

It began as a network that had learned in `standard`, and went on by PPO in `pairs`, with and against patrol,
contested_by_time, contested, triage and its own past (examples/train_ppo.py). It has not met the held-out opponents.
"""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """Its weights lie beside it; examples/train_ppo.py made them (docs/training.md)."""

    control = "velocity"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
