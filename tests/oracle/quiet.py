"""Oracles for their own tests: nothing happens in them that a test has not asked for."""

from collections.abc import Sequence
from typing import Any

from oracle.arena import Command, OracleArena

from catch_arena.config import ArenaConfig


def quiet(*, seed: int = 1, **settings: Any) -> OracleArena:
    """An oracle after its reset: one hunter under full control, no targets and no spawns, unless settings say so."""
    plain = {"hunters": 1, "control": "full", "initial_targets": settings.get("prey", 0), "spawn_frequency_hz": 0.001}
    arena = OracleArena(ArenaConfig().replace(**{**plain, **settings}).to_dict())
    arena.reset(seed)
    return arena


def drive(arena: OracleArena, *commands: Command, prey: Sequence[Command] = ()) -> None:
    """One step under full control in which nobody asks; who has no command stays where it is."""
    still = [(0.0, 0.0)] * (len(arena.hunters) - len(commands))
    play(arena, *((command, 0) for command in (*commands, *still)), prey=prey)


def play(arena: OracleArena, *actions: Any, prey: Sequence[Command] = ()) -> None:
    """One step; prey that has no command stands still."""
    arena.step(actions, [*prey, *[(0.0, 0.0)] * (len(arena.prey) - len(prey))])


def rest(arena: OracleArena, times: int = 1) -> None:
    """Steps in which nobody drives or asks."""
    for _ in range(times):
        drive(arena)
