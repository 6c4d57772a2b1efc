"""Environments for training: batches of arenas with opponents, and adapters for training libraries.

docs/howto/training.md shows their use.

Arenas with players:

- players: an agent in a batch, and the seats that the agents of one side play. opponents: those that are drawn.
- player_batch: arenas whose seats the caller gives to players and learners.
- learner_batch: a `PlayerBatch` that draws its opponents, with a row for each learner.
- sb3, gymnasium_vector, torchrl: `LearnerBatch` for each library.
- compiled: a decision for one hunter, compiled for many; scripted agents in agents/ act in batches by it.

Trained networks:

- networks: a perceptron in NumPy. columns_by_name: an observation with the columns that a network was trained with.
- flat: agents whose perceptron chooses a command from the observation.
- destinations, pointer: the places that a hunter can go to, with features, and agents whose network chooses one.

Names of this package load on first use. An adapter raises a ConfigError if its library is missing.
"""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from catch_arena.training.columns_by_name import fit_mask as fit_mask
    from catch_arena.training.columns_by_name import fit_observation as fit_observation
    from catch_arena.training.gymnasium_vector import GymnasiumVectorEnv as GymnasiumVectorEnv
    from catch_arena.training.learner_batch import LearnerBatch as LearnerBatch
    from catch_arena.training.networks import Mlp as Mlp
    from catch_arena.training.sb3 import SB3VecEnv as SB3VecEnv
    from catch_arena.training.torchrl import TorchRLEnv as TorchRLEnv

_HOMES = {
    "GymnasiumVectorEnv": "gymnasium_vector",
    "LearnerBatch": "learner_batch",
    "Mlp": "networks",
    "SB3VecEnv": "sb3",
    "TorchRLEnv": "torchrl",
    "fit_mask": "columns_by_name",
    "fit_observation": "columns_by_name",
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
