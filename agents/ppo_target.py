"""Chooses a target by a trained network; the arena's controller chases it.

It began with the weights of `ppo_destination`, and went on by PPO in `standard`, against patrol, contested_by_time,
contested, nearest and triage (examples/train_ppo.py --head rank). It has not met the held-out opponents of the suite.
"""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """Its weights lie beside it; examples/train_ppo.py made them (docs/training.md)."""

    control = "target"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
