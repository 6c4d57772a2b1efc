"""Networks that choose a destination: the trained agents that ship, and those of examples/train_ppo.py.

A network computes a logit for each candidate of `destinations`, from its features and from a summary of all candidates.
This is a pointer network (Vinyals, Fortunato and Jaitly, Pointer Networks, 2015). The summary is attention pooling with
learned queries, as in Lee et al., Set Transformer, 2019. The hunter goes to the candidate with the highest logit.
"""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from catch_arena.batch_policy import BatchView
from catch_arena.config import RULESET, Control
from catch_arena.errors import ConfigError
from catch_arena.files import whole_file
from catch_arena.policy import View
from catch_arena.steering import drive_each
from catch_arena.training.destinations import FEATURES, VERSION, Destinations, destinations
from catch_arena.training.networks import load_network, require_finite

Head = Literal["destination", "rank", "velocity"]
"""The network's decision: the place that the hunter drives to, the target that the arena's controller chases, or the
velocities themselves.
"""
CONTROL_OF: Final[dict[Head, Control]] = {"destination": "velocity", "rank": "target", "velocity": "velocity"}

QUERIES: Final = 2
"""Number of learned queries of the attention pooling."""

Float32Array = NDArray[np.float32]


class PointerNetwork:
    """A network that computes logits from features, in NumPy and float32.

    Args:
        head: the network's decision.
        weights: `encode` (F, H), `encode_bias` (H,), `attend` (H, QUERIES), `pool` (QUERIES * H, H), `mix` (H, H),
            `mix_bias` (H,), `logit` (H,); with the head "velocity" also `drive` (H, 2), `drive_bias` (2,); and `prior`
            (), which is added to the logit of the candidate that a scripted agent would choose.

    Raises:
        ConfigError: for weights that are missing, of another shape, or not finite.
    """

    def __init__(self, head: Head, weights: Mapping[str, ArrayLike]) -> None:
        if head not in get_args(Head):
            raise ConfigError(f"head must be one of {', '.join(get_args(Head))}, got {head!r}")
        self.head: Final = head
        self.weights: Final = {name: np.asarray(value, np.float32) for name, value in weights.items()}
        hidden = self.weights["mix"].shape[0] if self.weights.get("mix", np.zeros(())).ndim == 2 else 0
        for name, shape in weight_shapes(head, hidden).items():
            if name not in self.weights or self.weights[name].shape != shape:
                got = self.weights[name].shape if name in self.weights else "nothing"
                raise ConfigError(f"weights {name} must have the shape {shape}, got {got}")
            require_finite(f"weights {name}", self.weights[name])

    def __call__(self, seen: Destinations) -> tuple[Float32Array, Float32Array]:
        """Return the candidates' logits, (N, C), -inf if one is not legal, and the last hidden layer, (N, C, H)."""
        w = self.weights
        rows, candidates, width = seen.features.shape
        hidden = np.maximum(seen.features.reshape(-1, width) @ w["encode"] + w["encode_bias"], 0)
        attention = (hidden @ w["attend"]).reshape(rows, candidates, QUERIES)
        attention[~seen.legal] = -np.inf
        attention = np.exp(attention - attention.max(axis=1, keepdims=True))
        attention /= attention.sum(axis=1, keepdims=True)
        pooled = attention.transpose(0, 2, 1) @ hidden.reshape(rows, candidates, -1)  # (N, QUERIES, H)
        common = pooled.reshape(rows, -1) @ w["pool"] + w["mix_bias"]
        mixed = np.maximum((hidden @ w["mix"]).reshape(rows, candidates, -1) + common[:, None], 0)
        logits: Float32Array = mixed @ w["logit"]
        if not np.isfinite(logits).all():
            raise ConfigError("weights must be such that all logits are finite numbers: these are too large")
        logits[np.arange(rows), seen.preferred] += w["prior"]
        logits[~seen.legal] = -np.inf
        return logits, mixed

    def velocities(self, logits: Float32Array, mixed: Float32Array) -> Float32Array:
        """Return the velocities of the head "velocity", (N, 2) in [-1, 1]: the candidates' softmax-weighted mean."""
        chances = np.exp(logits - logits.max(axis=1, keepdims=True))
        chances /= chances.sum(axis=1, keepdims=True)
        drives = np.tanh(mixed @ self.weights["drive"] + self.weights["drive_bias"])
        result: Float32Array = (drives * chances[..., None]).sum(axis=1)
        return result

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the network to an .npz file."""
        tables: dict[str, Any] = {"head": self.head, "features": VERSION, "ruleset": RULESET, **self.weights}
        with whole_file(Path(path)) as file:
            np.savez_compressed(file, **tables)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "PointerNetwork":
        """Return the network from a file that `save` wrote, for this ruleset and these features."""
        known: dict[str, str | int] = {"features": VERSION, "ruleset": RULESET}
        return load_network(path, "PointerNetwork.save", known, lambda tables: cls(tables.pop("head").item(), tables))


def weight_shapes(head: Head, hidden: int) -> dict[str, tuple[int, ...]]:
    """Return the shape of each table of weights, for a network with `hidden` units per layer."""
    shapes: dict[str, tuple[int, ...]] = {
        "encode": (len(FEATURES), hidden),
        "encode_bias": (hidden,),
        "attend": (hidden, QUERIES),
        "pool": (QUERIES * hidden, hidden),
        "mix": (hidden, hidden),
        "mix_bias": (hidden,),
        "logit": (hidden,),
        "prior": (),
    }
    if head == "velocity":
        shapes |= {"drive": (hidden, 2), "drive_bias": (2,)}
    return shapes


class PointerAgent:
    """An agent that plays by a network, or by the file that holds one, and decides again in each step."""

    def __init__(self, network: PointerNetwork | str | os.PathLike[str]) -> None:
        self.network: Final = network if isinstance(network, PointerNetwork) else PointerNetwork.load(network)
        self.control: Control = CONTROL_OF[self.network.head]

    def reset(self, seed: int) -> None:
        """Begin an episode; there is no state to reset."""

    def act(self, view: View) -> Any:
        """Return the action of one hunter for this step."""
        (action,) = self.act_batch(view).tolist()
        return action

    def act_batch(self, view: BatchView | View) -> Any:
        """Return the actions of N hunters, or of one (N = 1): (N,) ranks or (N, 2) velocities."""
        seen = destinations(view)
        logits, mixed = self.network(seen)
        if self.network.head == "velocity":
            return np.clip(self.network.velocities(logits, mixed), -1, 1)
        choice = logits.argmax(axis=1)
        if self.network.head == "rank":
            return choice  # 0 holds, and the candidates after it are the targets by rank
        rows = np.arange(len(choice))
        return drive_each(seen.forward[rows, choice], seen.left[rows, choice], choice < seen.places, view.limits)
