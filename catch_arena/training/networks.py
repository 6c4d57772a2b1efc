"""A trained network without the library that trained it: NumPy alone, loaded in milliseconds."""

import os
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from catch_arena.errors import ConfigError, reason

Layers = list[tuple[NDArray[np.float32], NDArray[np.float32]]]

ACTIVATIONS: Final = {"tanh": np.tanh, "relu": lambda x: np.maximum(x, 0)}


class Mlp:
    """A multi-layer perceptron: weights (out, in) and biases (out,) by layer, and an activation between them.

    Args:
        layers: a (weights, biases) for each, from the first to the last.
        activation: "tanh" or "relu".

    Raises:
        ConfigError: for layers that do not fit together.
    """

    def __init__(self, layers: list[tuple[ArrayLike, ArrayLike]], activation: str = "tanh") -> None:
        if activation not in ACTIVATIONS:
            raise ConfigError(f"activation must be one of {', '.join(ACTIVATIONS)}, got {activation!r}")
        self.activation: Final = activation
        self.layers: Final[Layers] = [(np.asarray(w, np.float32), np.asarray(b, np.float32)) for w, b in layers]
        shapes = [(w.shape, b.shape) for w, b in self.layers]
        fits = bool(shapes) and all(len(w) == 2 and b == w[:1] for w, b in shapes)
        if not fits or any(after[0][1] != before[0][0] for before, after in pairwise(shapes)):
            raise ConfigError(f"layers must be weights (out, in) and biases (out,) that fit together, got {shapes}")

    @classmethod
    def of_torch(cls, *modules: Any, scale: ArrayLike | None = None) -> "Mlp":
        """The same network as these modules of torch one behind the other: Linear, Tanh, ReLU, and Sequential of them.

        Args:
            modules: for stable-baselines3's MlpPolicy `policy.mlp_extractor.policy_net, policy.action_net`.
            scale: `env.batch.scale`, where the network has learned from normalised observations: this one takes
                them as they are.

        Raises:
            ConfigError: for other modules.
        """
        layers: list[tuple[ArrayLike, ArrayLike]] = []
        used = set()
        for module in [inner for outer in modules for inner in _parts(outer)]:
            kind = type(module).__name__
            if kind == "Linear":
                layers.append((module.weight.detach().cpu().numpy(), module.bias.detach().cpu().numpy()))
            elif kind.lower() in ACTIVATIONS:
                used.add(kind.lower())
            else:
                raise ConfigError(f"modules must be Linear, Tanh and ReLU, got {kind}")
        if len(used) > 1:
            raise ConfigError(f"modules must have one kind of activation, got {', '.join(sorted(used))}")
        if scale is not None and layers:
            weights, biases = layers[0]
            layers[0] = np.asarray(weights) / np.asarray(scale), biases
        return cls(layers, *used)

    @property
    def inputs(self) -> int:
        """How many numbers it takes."""
        return len(self.layers[0][0].T)

    def __call__(self, observations: ArrayLike) -> NDArray[np.float32]:
        """(..., inputs) to (..., outputs).

        Raises:
            ConfigError: for observations of another width: those of another scenario.
        """
        x = np.asarray(observations, np.float32)
        if x.shape[-1:] != (self.inputs,):
            raise ConfigError(f"observations must have {self.inputs} numbers for this network, got {x.shape[-1:]}")
        *hidden, (weights, biases) = self.layers
        activate: Any = ACTIVATIONS[self.activation]
        for inner, offset in hidden:
            x = activate(x @ inner.T + offset)
        result: NDArray[np.float32] = x @ weights.T + biases
        return result

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write it to an .npz file."""
        tables: dict[str, Any] = {"activation": np.array(self.activation)}
        for place, (weights, biases) in enumerate(self.layers):
            tables |= {f"w_{place}": weights, f"b_{place}": biases}
        with Path(path).open("wb") as file:
            np.savez(file, **tables)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Mlp":
        """Read what `save` wrote.

        Raises:
            ConfigError: for a file that is none.
        """
        try:
            with np.load(path) as file:
                layers = [(file[f"w_{i}"], file[f"b_{i}"]) for i in range(len(file.files) // 2)]
                return cls(list(layers), str(file["activation"]))
        except (OSError, ValueError, KeyError) as error:
            raise ConfigError(f"{path}: must be what Mlp.save writes: {reason(error)}") from None


def _parts(module: Any) -> list[Any]:
    inner = list(module.children())
    return [part for child in inner for part in _parts(child)] if inner else [module]
