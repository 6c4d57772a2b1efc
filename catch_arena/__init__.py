"""Catch Arena: several hunters chase spawned targets in turtlesim's arena, and a central arbiter judges their catch
requests.

The names listed here are loaded on first use, so that `import catch_arena` is fast. docs/explanation/architecture.md
describes each folder and module.
"""

TYPE_CHECKING = False  # not imported from typing, which takes longer to load than this module
if TYPE_CHECKING:
    from typing import Any

    from catch_arena.arbitration import arbitrate as arbitrate
    from catch_arena.batch_policy import BatchView as BatchView
    from catch_arena.batch_policy import PreyBatchView as PreyBatchView
    from catch_arena.config import ArenaConfig as ArenaConfig
    from catch_arena.config import FaultRates as FaultRates
    from catch_arena.config import Gains as Gains
    from catch_arena.config import RewardWeights as RewardWeights
    from catch_arena.engine import Engine as Engine
    from catch_arena.envs.aec import env as env
    from catch_arena.envs.parallel import CatchArenaEnv as CatchArenaEnv
    from catch_arena.envs.parallel import parallel_env as parallel_env
    from catch_arena.envs.vector import VectorArena as VectorArena
    from catch_arena.errors import CatchArenaError as CatchArenaError
    from catch_arena.explanation import explain as explain
    from catch_arena.explanation import explain_step as explain_step
    from catch_arena.explanation import what_if as what_if
    from catch_arena.layout import columns as columns
    from catch_arena.policy import Limits as Limits
    from catch_arena.policy import Policy as Policy
    from catch_arena.policy import PreyLimits as PreyLimits
    from catch_arena.policy import PreyPolicy as PreyPolicy
    from catch_arena.policy import PreyView as PreyView
    from catch_arena.policy import View as View
    from catch_arena.replay import Replay as Replay
    from catch_arena.ros.arena_service import ArenaService as ArenaService
    from catch_arena.scenarios import SCENARIOS as SCENARIOS
    from catch_arena.scenarios import scenario as scenario
    from catch_arena.verdicts import Ruling as Ruling
    from catch_arena.verdicts import Verdict as Verdict
    from catch_arena.world import World as World

_NAMES = {
    "arbitration": ("arbitrate",),
    "batch_policy": ("BatchView", "PreyBatchView"),
    "config": ("ArenaConfig", "FaultRates", "Gains", "RewardWeights"),
    "engine": ("Engine",),
    "envs.aec": ("env",),
    "envs.parallel": ("CatchArenaEnv", "parallel_env"),
    "envs.vector": ("VectorArena",),
    "errors": ("CatchArenaError",),
    "explanation": ("explain", "explain_step", "what_if"),
    "layout": ("columns",),
    "player": ("Replay",),  # it is defined in replay/; importing the player adds its view in notebooks
    "policy": ("Limits", "Policy", "PreyLimits", "PreyPolicy", "PreyView", "View"),
    "ros.arena_service": ("ArenaService",),
    "scenarios": ("SCENARIOS", "scenario"),
    "verdicts": ("Ruling", "Verdict"),
    "world": ("World",),
}
_HOMES = {name: module for module, names in _NAMES.items() for name in names}

__all__ = sorted(_HOMES)  # noqa: PLE0605 - a list of strings, though not a literal one


def __getattr__(name: str) -> "Any":
    if name not in _HOMES:
        raise AttributeError(f"module 'catch_arena' has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(f"catch_arena.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
