"""A person as an agent."""

from typing import ClassVar

from catch_arena.config import Control
from catch_arena.live.keys import Hands
from catch_arena.policy import View


class Person:
    """Drives by hand; the nearest target within reach is requested for it (R4.4)."""

    control: ClassVar[Control] = "velocity"

    def __init__(self, hands: Hands) -> None:
        self._hands = hands

    def reset(self, seed: int) -> None:
        """Nothing is held from the match before."""
        del seed
        self._hands.drop()

    def act(self, view: View) -> tuple[float, float]:
        """What the hands say."""
        del view
        return self._hands.command()
