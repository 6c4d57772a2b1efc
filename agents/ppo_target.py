"""Trained by PPO against scripted agents and itself: chooses a target, which the arena's controller chases."""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """Its weights lie beside it; scripts/train_ppo.py made them (docs/training.md)."""

    control = "target"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
