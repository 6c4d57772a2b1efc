"""Trained by PPO against scripted agents and itself: chooses where to go, and drives as `patrol` does."""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """Its weights lie beside it; scripts/train_ppo.py made them (docs/training.md)."""

    control = "velocity"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
