"""Looks ahead: tries each place to go to in an arena of its own, with rivals as it expects them.

What is in view is copied into a light arena (`catch_arena.lookahead`), once for each place that the hunter could go to:
the targets, some points to wait at, and where it is. All copies are played on for some seconds, in which everybody runs
the race that suits it best; then the hunter goes where that was worth most. The work of a move is bounded, whatever is
in view and however fast the machine is, so that a match can be repeated. Nothing is remembered or drawn.
"""

import numpy as np
from numpy.typing import NDArray

from catch_arena.batch_policy import BatchView
from catch_arena.lookahead import Scene, Weights, drive_to, look_ahead
from catch_arena.policy import View


class Agent:
    """Drives itself to the place from where it expects most, and decides anew in every step."""

    control = "velocity"
    weights = Weights()

    def reset(self, seed: int) -> None:
        """Nothing to forget, and nothing is drawn."""

    def act(self, view: View) -> tuple[float, float]:
        """Speed and turn rate as parts of the limits, in [-1, 1]."""
        observations = np.array([view.observation], dtype=np.float32)
        masks = np.zeros((1, 0), dtype=np.int8)
        speed, turn = self.act_batch(BatchView(observations, masks, view.limits))[0].tolist()
        return speed, turn

    def act_batch(self, view: BatchView) -> NDArray[np.float64]:
        """The same for N hunters: (N, 2)."""
        scene = Scene.of(view)
        return drive_to(scene, look_ahead(scene, self.weights).argmax(axis=1))
