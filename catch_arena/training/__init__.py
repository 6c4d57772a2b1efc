"""Environments for training: batches of arenas with opponents, and adapters for training libraries.

docs/howto/training.md shows their use.

- batch: many arenas in which some seats learn. players: agents and the seats that they play. opponents: those that are
  drawn for the seats of hunters that do not learn. compiled: a decision for one hunter, compiled for many hunters.
- sb3, gymnasium_vector, torchrl: adapters, one for each library.
- networks: a trained network in NumPy. fitting: an observation in the width that a network was trained with.
- destinations, pointer: candidate places as inputs of a network, and the networks that choose one.
- mixed: many arenas whose hunters and prey each have a player. flat: agents that choose a command by a network.

Names of this package load on first use. An adapter raises a ConfigError if its library is missing.
"""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from catch_arena.training.batch import LearnerBatch as LearnerBatch
    from catch_arena.training.fitting import fit_mask as fit_mask
    from catch_arena.training.fitting import fit_observation as fit_observation
    from catch_arena.training.gymnasium_vector import GymnasiumVectorEnv as GymnasiumVectorEnv
    from catch_arena.training.networks import Mlp as Mlp
    from catch_arena.training.sb3 import SB3VecEnv as SB3VecEnv
    from catch_arena.training.torchrl import TorchRLEnv as TorchRLEnv

_HOMES = {
    "GymnasiumVectorEnv": "gymnasium_vector",
    "LearnerBatch": "batch",
    "Mlp": "networks",
    "SB3VecEnv": "sb3",
    "TorchRLEnv": "torchrl",
    "fit_mask": "fitting",
    "fit_observation": "fitting",
}
_EXTRAS = {"stable_baselines3": "sb3", "torch": "torchrl", "torchrl": "torchrl", "tensordict": "torchrl"}
"""The extra of the package that installs each library."""

__all__ = ["GymnasiumVectorEnv", "LearnerBatch", "Mlp", "fit_mask", "fit_observation"]
"""Names that need no training library; `__getattr__` also offers the adapters."""


def __getattr__(name: str) -> "Any":
    if name not in _HOMES:
        raise AttributeError(f"module 'catch_arena.training' has no attribute {name!r}")
    from importlib import import_module

    from catch_arena.errors import ConfigError, install_hint

    try:
        module = import_module(f"catch_arena.training.{_HOMES[name]}")
    except ModuleNotFoundError as error:
        library = (error.name or "").partition(".")[0]
        if library not in _EXTRAS:
            raise
        raise ConfigError(f"{name} needs {library}, which is not installed: {install_hint(_EXTRAS[library])}") from None
    value = getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
