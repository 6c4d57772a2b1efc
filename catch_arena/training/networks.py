"""Trained networks in NumPy, without the library that trained them; they load in milliseconds."""

import os
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from catch_arena.config import RULESET
from catch_arena.errors import ConfigError, reason
from catch_arena.files import whole_file

T = TypeVar("T")

ACTIVATIONS: Final = {"tanh": np.tanh, "relu": lambda x: np.maximum(x, 0)}


class Mlp:
    """A multi-layer perceptron: weights (out, in) and biases (out,) by layer, and an activation between layers.

    Args:
        layers: (weights, biases) of each layer, from the first to the last.
        activation: "tanh" or "relu".

    Raises:
        ConfigError: for layers that do not fit together, and for numbers that are not finite.
    """

    def __init__(self, layers: Sequence[tuple[ArrayLike, ArrayLike]], activation: str = "tanh") -> None:
        if activation not in ACTIVATIONS:
            raise ConfigError(f"activation must be one of {', '.join(ACTIVATIONS)}, got {activation!r}")
        self.activation: Final = activation
        self.layers: Final = [(np.asarray(w, np.float32), np.asarray(b, np.float32)) for w, b in layers]
        shapes = [(w.shape, b.shape) for w, b in self.layers]
        fits = bool(shapes) and all(len(w) == 2 and b == w[:1] for w, b in shapes)
        if not fits or any(after[0][1] != before[0][0] for before, after in pairwise(shapes)):
            raise ConfigError(f"layers must be weights (out, in) and biases (out,) that fit together, got {shapes}")
        for place, layer in enumerate(self.layers):
            for name, numbers in zip(("weights", "biases"), layer, strict=True):
                require_finite(f"{name} of layer {place}", numbers)

    @classmethod
    def of_torch(cls, *modules: Any, scale: ArrayLike | None = None) -> "Mlp":
        """Return the network that some torch modules form in sequence: Linear, Tanh, ReLU, and Sequential of them.

        Args:
            modules: for stable-baselines3's MlpPolicy `policy.mlp_extractor.policy_net, policy.action_net`.
            scale: `env.batch.scale`, if the network was trained with normalised observations; the returned one takes
                observations that are not normalised.

        Raises:
            ConfigError: for other modules.
        """
        layers: list[tuple[ArrayLike, ArrayLike]] = []
        used = set()
        for module in [inner for outer in modules for inner in _parts(outer)]:
            kind = type(module).__name__
            if kind == "Linear":
                layers.append(tuple(one.detach().cpu().numpy().copy() for one in (module.weight, module.bias)))
            elif kind.lower() in ACTIVATIONS:
                used.add(kind.lower())
            else:
                raise ConfigError(f"modules must be Linear, Tanh and ReLU, got {kind}")
        if len(used) > 1:
            raise ConfigError(f"modules must all have the same activation, got {', '.join(sorted(used))}")
        if scale is not None and layers:
            weights, biases = layers[0]
            layers[0] = np.asarray(weights) / np.asarray(scale), biases
        return cls(layers, *used)

    @property
    def inputs(self) -> int:
        """Width of the observations that the network takes."""
        return len(self.layers[0][0].T)

    def __call__(self, observations: ArrayLike) -> NDArray[np.float32]:
        """Return the outputs, (..., outputs), for observations, (..., inputs).

        Raises:
            ConfigError: for observations of another width, as in another scenario.
        """
        x = np.asarray(observations, np.float32)
        if x.shape[-1:] != (self.inputs,):
            raise ConfigError(f"observations must have {self.inputs} columns for this network, got the shape {x.shape}")
        *hidden, (weights, biases) = self.layers
        activate: Any = ACTIVATIONS[self.activation]
        for inner, offset in hidden:
            x = activate(x @ inner.T + offset)
        result: NDArray[np.float32] = x @ weights.T + biases
        return result

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the network to an .npz file.

        Raises:
            OutputError: if the file cannot be written; an existing file is kept.
        """
        tables: dict[str, Any] = {"activation": self.activation, "ruleset": RULESET}
        for place, (weights, biases) in enumerate(self.layers):
            tables |= {f"w_{place}": weights, f"b_{place}": biases}
        with whole_file(Path(path)) as file:
            np.savez(file, **tables)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Mlp":
        """Return the network from a file that `save` wrote.

        Raises:
            ConfigError: for a file of another kind, a damaged one, or one of another ruleset.
        """

        def made(tables: dict[str, NDArray[Any]]) -> Mlp:
            activation, count = tables.pop("activation").item(), (len(tables) + 1) // 2
            return cls([(tables[f"w_{place}"], tables[f"b_{place}"]) for place in range(count)], activation)

        return load_network(path, "Mlp.save", {"ruleset": RULESET}, made)


def load_network(
    path: str | os.PathLike[str],
    written_by: str,
    known: dict[str, str | int],
    make: Callable[[dict[str, NDArray[Any]]], T],
) -> T:
    """Return the network that `make` makes of the tables in an .npz file, which is read without pickles.

    The file must have the single values of `known`, which `make` does not get. Raise ConfigError for a damaged file, or
    for one that the function named `written_by` did not write.
    """
    try:
        with Path(path).open("rb") as raw, np.load(raw) as file:
            tables = {name: file[name] for name in file.files}
        for name, value in known.items():
            if (found := tables.pop(name).item()) != value:
                raise ConfigError(f"{name} must be {value}, got {found}; train the network again")
        return make(tables)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from None
    except Exception as error:  # noqa: BLE001 - zipfile, zlib and NumPy raise errors of any type for a damaged file
        raise ConfigError(f"{path}: cannot load a file from {written_by}: {reason(error)}") from None


def require_finite(name: str, numbers: NDArray[np.float32]) -> None:
    """Raise a ConfigError if any of the numbers is infinite or NaN."""
    wrong = numbers[~np.isfinite(numbers)]
    if len(wrong):
        raise ConfigError(f"{name} must be finite numbers, got {wrong[0]}")


def _parts(module: Any) -> list[Any]:
    inner = list(module.children())
    return [part for child in inner for part in _parts(child)] if inner else [module]
