"""Where a step's time goes, phase by phase, and how far the batch is from the machine's limit.

The phases are compiled as one piece, so a phase's time is measured as what the step gains when it is compiled
without that phase. Every call starts from the same saved state, in the middle of an episode.
"""

import functools
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import catch_arena
from catch_arena.core import observations, tick
from catch_arena.core.jit import Block, phase, unkept_entry
from catch_arena.core.memory import Sections
from catch_arena.core.observations import prefetch_part
from catch_arena.core.ranking import Keys
from catch_arena.core.state import LANES, Settings
from catch_arena.core.vectors import Width, group

WHOLE = "the whole step"
_LARGE = 16384


class Played(NamedTuple):
    """A batch whose step is taken apart."""

    title: str
    envs: int
    settings: Mapping[str, Any] = {}
    age: int = 100
    """How many steps it has played; an episode has 600."""


_MANY: Mapping[str, Any] = {"hunters": 64, "initial_targets": 16, "spawn_frequency_hz": 10.0}
_BATCHES = (
    Played("1,024 arenas", 1024),
    Played("16,384 arenas", _LARGE),
    Played("full control", _LARGE, {"control": "full"}),
    Played("64 hunters", 1024, _MANY),
    Played("64 hunters, late", 1024, _MANY, age=550),
)


@phase
def _nothing(*_: object) -> None:
    """A phase that does nothing."""


@phase
def _targets_as_they_lie(
    _block: Block,
    _me: Block,
    _targets: Block,
    first: int,
    width: Width,
    slots: int,
    _s: Settings,
    _reach_limit_m2: float,
    keys: Keys,
) -> None:
    """In the place of `rank_targets`: in the order of their slots."""
    for slot in range(slots):
        keys[slot * LANES + group(first, width)] = slot


@phase
def _next_block_read_ahead(
    _block: Block,
    _s: Settings,
    _width: Width,
    _lanes: int,
    _slots: int,
    _teams: NDArray[np.int64],
    _sections: Sections,
    _out: NDArray[np.float32],
    _arena: int,
    ahead: Block,
) -> None:
    """In the place of `observations.write`, which does so as it goes: the other phases gain by it."""
    prefetch_part(ahead, 0, 1)


_RIVALS = "note_positions", "measure_rivals", "sort_keys", "resolve_ties"
_PHASES: dict[str, tuple[ModuleType, dict[str, Any]]] = {
    "intake and hosted controllers": (tick, {"apply_actions": _nothing}),
    "arbiter and commit": (tick, {"resolve_requests": _nothing}),
    "motion": (tick, {"move": _nothing}),
    "spawning": (tick, {"spawn_through": _nothing}),
    "rewards": (tick, {"reward": _nothing}),
    "targets in order": (observations, {"rank_targets": _targets_as_they_lie}),
    "rivals in order": (observations, dict.fromkeys(_RIVALS, _nothing)),
    "observations and masks written": (observations, {"write": _next_block_read_ahead}),
}
"""What stands in each phase's place."""
_CALLER = "run"
"""What the engine calls."""
_CALLED = ((observations, "rank_seen"), (tick, "observe"), (tick, "play"))
"""What that calls, with the modules in which the callers look; and these call all phases. Who is called comes first."""


def _compiled_without(title: str) -> Any:
    """The step without that phase. Numba reads the names in a module when it compiles, at the first call; what it has
    compiled it keeps, so that all that calls the phase is made anew.
    """
    module, stand_ins = _PHASES[title]
    for name, stand_in in stand_ins.items():
        setattr(module, name, stand_in)
    for caller, name in _CALLED:
        setattr(caller, name, phase(getattr(caller, name).py_func))
    setattr(tick, _CALLER, unkept_entry(getattr(tick, _CALLER).py_func))
    return getattr(tick, _CALLER)


def _time(run: Callable[[], object]) -> float:
    begin = time.process_time()
    run()
    return time.process_time() - begin


def _undisturbed(spent: Sequence[float]) -> float:
    """The lowest tenth's bound: what other guests of the machine add would hide the small phases."""
    return statistics.quantiles(spent, n=10)[0]


def _time_from(saved: NDArray[np.float64], engine: catch_arena.Engine, step: Callable[[], None]) -> float:
    """CPU-seconds of one step from that state: the mean of as many as make a large batch, after one that fills the
    caches.
    """
    spent = []
    for _ in range(1 + max(1, 4 * _LARGE // (engine.num_arenas * engine.config.hunters))):
        engine.blocks[:] = saved
        spent.append(_time(step))
    return statistics.mean(spent[1:])


def phases(*, quick: bool) -> list[dict[str, Any]]:
    """For batches that fit the caches and that do not, under full control and with many hunters: CPU-nanoseconds an
    agent and step by phase, and for plain memory traffic of the same size.

    Each batch has a process of its own: in memory that another one has used before, a step takes up to half as long
    again.
    """
    if quick:
        return _in_this_process((Played("one arena", 1), Played("33 arenas", 33)), quick=True)
    found = []
    for place in range(len(_BATCHES)):
        command = [sys.executable, __file__, str(place)]
        done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
        found += json.loads(done.stdout)
    return found


def _in_this_process(batches: Sequence[Played], *, quick: bool) -> list[dict[str, Any]]:
    titles = list(_PHASES)[:1] if quick else list(_PHASES)
    small = Played("33 arenas", 33)
    _at_play(small)  # the whole step is compiled, and kept for other processes, before anything stands in for a phase
    changed: list[tuple[ModuleType, str]] = [*_CALLED, (tick, _CALLER)]
    changed += [(module, name) for module, stand_ins in _PHASES.values() for name in stand_ins]
    originals = [(module, name, getattr(module, name)) for module, name in changed]
    variants = {"": getattr(tick, _CALLER)}
    try:
        for title in titles:
            variants[title] = _compiled_without(title)
            _at_play(small)  # compiles
            for module, name, original in originals:
                setattr(module, name, original)
        return [_measured(batch, variants, rounds=3 if quick else 61) for batch in batches]
    finally:
        for module, name, original in originals:
            setattr(module, name, original)


def _at_play(batch: Played) -> tuple[catch_arena.Engine, Callable[[], None]]:
    """A batch within an episode, and its step; of many hunters each chases a rank of its own."""
    config = catch_arena.scenario("standard", **batch.settings)
    engine = catch_arena.Engine(config, batch.envs, with_infos=False)
    engine.reset(range(batch.envs))
    choices = np.ones((batch.envs, config.hunters), dtype=np.int64)
    if "hunters" in batch.settings:
        choices += np.arange(config.hunters) % config.targets_seen
    full = config.control == "full"
    drawn = np.random.default_rng(1).uniform(-1, 1, (batch.envs, config.hunters, 2))
    commands = (drawn if full else np.zeros_like(drawn)).astype(np.float32)

    def step() -> None:
        engine.step(choices, commands)

    for _ in range(batch.age):
        step()
    return engine, step


def play_by(engine: catch_arena.Engine, run: Any) -> None:
    """Have an engine play by this in place of the `tick.run` that it looked up when it was made."""
    engine._run_tick = functools.partial(run, *engine._compiled_for, engine._memory)  # noqa: SLF001


def _measured(batch: Played, variants: Mapping[str, Any], rounds: int) -> dict[str, Any]:
    engine, step = _at_play(batch)
    saved = engine.blocks.copy()
    output = np.empty(sum(array.nbytes for array in (engine.observations, engine.masks, engine.rewards)), np.uint8)
    state = saved.copy()
    spent: dict[str, list[float]] = {name: [] for name in (*variants, "fill", "touch")}
    names = list(variants)
    for _ in range(rounds):
        names.append(names.pop(0))  # nobody always comes after the same one
        for name in names:
            play_by(engine, variants[name])
            spent[name].append(_time_from(saved, engine, step))
        spent["fill"].append(_time(lambda: output.fill(1)))
        spent["touch"].append(spent["fill"][-1] + _time(lambda: np.negative(state, out=state)))

    agents = batch.envs * engine.config.hunters
    ns = {name: 1e9 * _undisturbed(seconds) / agents for name, seconds in spent.items()}
    gains = {title: ns[""] - ns[title] for title in variants if title}
    return {
        "title": batch.title,
        "envs": batch.envs,
        "bytes_written_per_agent_step": output.nbytes / agents,
        "state_bytes_per_agent": state.nbytes / agents,
        "fill_gigabytes_per_s": output.nbytes / agents / ns["fill"],
        "ns_per_agent_step": {
            **gains,
            "the rest": ns[""] - sum(gains.values()),
            WHOLE: ns[""],
            "writing what a step writes, no more": ns["fill"],
            "and reading and writing the state": ns["touch"],
        },
    }


if __name__ == "__main__":
    print(json.dumps(_in_this_process([_BATCHES[int(sys.argv[1])]], quick=False)))
