"""Where a step's time goes, phase by phase, and how far the batch is from the machine's limit.

The phases are compiled into one function, so a phase's time is measured as what the step gains when it is compiled
without that phase. Every call starts from the same saved state, in the middle of an episode.
"""

import itertools
import statistics
import time
from collections.abc import Callable, Mapping
from typing import Any

import numba
import numpy as np

import catch_arena
from catch_arena.core import tick

_PHASES = {
    "intake and hosted controllers": ("take_in",),
    "arbiter and commit": ("arbitrate", "commit"),
    "motion": ("move",),
    "spawning": ("spawn_through",),
    "rewards": ("reward",),
    "observations and masks": ("observe",),
}
WHOLE = "the whole step"
_CALLER = "run"
"""What the engine calls; all that is between it and the phases is inlined before it is compiled."""


@numba.njit(nogil=True, error_model="numpy", _nrt=False)
def _nothing(*_: object) -> None:
    """A phase that does nothing."""


def _compiled_without(phases: tuple[str, ...]) -> Any:
    """The step without those phases. Numba reads the names in a module when it compiles, at the first call."""
    for name in phases:
        setattr(tick, name, _nothing)
    caller = getattr(tick, _CALLER)
    setattr(tick, _CALLER, numba.jit(**caller.targetoptions)(caller.py_func))
    return getattr(tick, _CALLER)


def _time(run: Callable[[], object]) -> float:
    begin = time.process_time()
    run()
    return time.process_time() - begin


def phases(*, quick: bool) -> list[dict[str, Any]]:
    """For batches that fit the caches and that do not: CPU-nanoseconds an agent and step by phase, and for plain memory
    traffic of the same size.
    """
    titles = list(_PHASES)[:1] if quick else list(_PHASES)
    originals = {name: getattr(tick, name) for name in (*itertools.chain(*_PHASES.values()), _CALLER)}
    variants = {"": originals[_CALLER]}
    try:
        for title in titles:
            variants[title] = _compiled_without(_PHASES[title])
            _at_play(33)  # compiles
            for name, original in originals.items():
                setattr(tick, name, original)
        return [_measured(envs, variants, rounds=3 if quick else 41) for envs in ((1, 33) if quick else (1024, 16384))]
    finally:
        for name, original in originals.items():
            setattr(tick, name, original)


def _at_play(envs: int) -> tuple[catch_arena.Engine, Callable[[], None]]:
    """A batch in the middle of an episode, and its step."""
    config = catch_arena.scenario("standard")
    engine = catch_arena.Engine(config, envs, parts_wanted=False)
    engine.reset(range(envs))
    choices = np.ones((envs, config.hunters), dtype=np.int64)
    commands = np.zeros((envs, config.hunters, 2), dtype=np.float32)

    def step() -> None:
        engine.step(choices, commands)

    for _ in range(100):
        step()
    return engine, step


def _measured(envs: int, variants: Mapping[str, Any], rounds: int) -> dict[str, Any]:
    engine, step = _at_play(envs)
    saved = engine.memory.copy()
    output = np.empty(sum(array.nbytes for array in (engine.observations, engine.masks, engine.rewards)), np.uint8)
    state = saved.copy()
    spent: dict[str, list[float]] = {name: [] for name in (*variants, "fill", "touch")}
    for _ in range(rounds):
        for name, variant in variants.items():
            engine.memory[:] = saved
            setattr(tick, _CALLER, variant)
            spent[name].append(_time(step))
        spent["fill"].append(_time(lambda: output.fill(1)))
        spent["touch"].append(spent["fill"][-1] + _time(lambda: np.negative(state, out=state)))

    agents = envs * engine.config.hunters
    whole = spent[""]
    gains = {
        title: statistics.median(one - other for one, other in zip(whole, spent[title], strict=True))
        for title in variants
        if title
    }
    gains["the rest"] = statistics.median(whole) - sum(gains.values())
    return {
        "envs": envs,
        "bytes_written_per_agent_step": output.nbytes / agents,
        "state_bytes_per_agent": state.nbytes / agents,
        "fill_gigabytes_per_s": output.nbytes / statistics.median(spent["fill"]) / 1e9,
        "ns_per_agent_step": {
            **{title: 1e9 * gain / agents for title, gain in gains.items()},
            WHOLE: 1e9 * statistics.median(whole) / agents,
            "writing what a step writes, no more": 1e9 * statistics.median(spent["fill"]) / agents,
            "and reading and writing the state": 1e9 * statistics.median(spent["touch"]) / agents,
        },
    }
