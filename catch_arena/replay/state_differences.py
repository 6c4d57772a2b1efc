"""Differences of two states of a match, number by number, in words."""

from collections.abc import Sequence
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.replay.states import MICRO, QuantisedState, parts_of, tables_of

_MOST_LINES: Final = 12


def state_name(step: int) -> str:
    """Return the name of the state after `step` steps."""
    return "the initial state" if step == 0 else f"step {step}"


def state_differences(
    config: ArenaConfig,
    names: Sequence[str],
    first: QuantisedState,
    second: QuantisedState,
    labels: tuple[str, str] = ("as recorded", "as replayed"),
) -> list[str]:
    """Return a line for each of the first numbers in which two states differ, and the number of further ones.

    There is at least one line, because digests can differ although all quantised numbers agree.

    Args:
        config: the arena's settings.
        names: the agents' names, of the hunters by seat and then of the prey by index.
        first: the first state.
        second: the second state.
        labels: the names of the states in the lines.
    """
    found = []
    parts = zip(tables_of(config), _by_body(config, names, first), _by_body(config, names, second), strict=True)
    for quantities, here, there in parts:
        for body in here | there:
            if body not in here or body not in there:
                alive, gone = labels if body in here else labels[::-1]
                found.append(f"{body}: alive {alive}, not {gone}")
                continue
            for (quantity, unit), *values in zip(quantities.items(), here[body], there[body], strict=True):
                if values[0] != values[1]:
                    one, other = (_shown(config, unit, value) for value in values)
                    found.append(f"{body}: {quantity} is {one} {labels[0]} and {other} {labels[1]}")
    if len(found) > _MOST_LINES:
        found[_MOST_LINES:] = [f"{len(found) - _MOST_LINES} more"]
    return found or ["every number differs by less than a millionth of its unit"]


def _by_body(config: ArenaConfig, names: Sequence[str], state: QuantisedState) -> tuple[dict[str, list[int]], ...]:
    """Return the numbers of the arena, of each hunter, of each target and of each prey, by name."""
    own = config.hunter_names + config.prey_names
    agents = [name if name == label else f"{name} ({label})" for name, label in zip(own, names, strict=True)]
    arena, hunters, targets, prey = (part.tolist() for part in parts_of(state, config))
    return (
        {"clock and counters": arena[0]},
        dict(zip(agents[: config.hunters], hunters, strict=True)),
        {config.target_name(row[0]): row for row in targets},
        dict(zip(agents[config.hunters :], prey, strict=True)),
    )


def _shown(config: ArenaConfig, unit: str, value: int) -> str:
    if unit in MICRO:
        return f"{value / 1e6:.6f} {unit}"
    if unit == "target":
        return config.target_name(value) if value else "none"
    if unit == "flag":
        return "yes" if value else "no"
    return f"{value} {unit}".strip()
