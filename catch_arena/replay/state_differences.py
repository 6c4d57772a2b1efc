"""Differences of two states of a match, number by number, in words."""

from collections.abc import Sequence
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.core.math import wrap
from catch_arena.replay.states import CAUGHT_AT, MICRO, QuantisedState, parts_of, tables_of

_MOST_LINES: Final = 12


def state_name(step: int) -> str:
    """Return the name of the state after `step` steps."""
    return "the initial state" if step == 0 else f"step {step}"


def on_one_line(differences: Sequence[str]) -> str:
    """Return the first difference, and the number of further ones."""
    more = f" (and {len(differences) - 1} more)" if len(differences) > 1 else ""
    return f"{differences[0]}{more}"


def first_lines(step: int, differences: Sequence[str]) -> list[str]:
    """Return a line for each of the first differences, with the step, and one with the number of further ones."""
    shown = [f"{state_name(step)}: {line}" for line in differences[:_MOST_LINES]]
    more = len(differences) - _MOST_LINES
    return [*shown, f"{state_name(step)}: {more} more difference{'s' * (more > 1)}"] if more > 0 else shown


def state_differences(
    config: ArenaConfig,
    names: Sequence[str],
    first: QuantisedState,
    second: QuantisedState,
    labels: tuple[str, str] = ("as recorded", "as replayed"),
) -> list[str]:
    """Return a line for each number in which two states with different digests differ; at least one line.

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
                    one, other = (_shown(config, quantity, unit, value) for value in values)
                    apart = _apart(config, quantity, unit, values)
                    found.append(f"{body}: {quantity} is {one} {labels[0]} and {other} {labels[1]}{apart}")
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


def _apart(config: ArenaConfig, quantity: str, unit: str, values: Sequence[int]) -> str:
    """Return the difference of two values in words; "" if it has no meaning."""
    if unit in ("target", "flag") or (quantity == CAUGHT_AT and min(values) < 0):
        return ""
    apart = abs(values[1] - values[0])
    if quantity == "theta":
        apart = round(1e6 * abs(wrap(apart / 1e6)))
    return f", {_shown(config, quantity, unit, apart)} apart"


def _shown(config: ArenaConfig, quantity: str, unit: str, value: int) -> str:
    if unit in MICRO:
        return f"{value / 1e6:.6f} {unit}"
    if unit == "target":
        return config.target_name(value) if value else "none"
    if unit == "flag":
        return "yes" if value else "no"
    if quantity == CAUGHT_AT and value < 0:
        return "not out"
    return f"{value} {unit}".strip()
