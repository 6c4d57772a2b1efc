"""Differences of two states of a match, number by number, in words."""

import math
from collections.abc import Sequence
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.core.math import wrap
from catch_arena.replay.states import ARENA, HUNTER, MICRO, OUT, PREY, QuantisedState, parts_of, target_numbers

_MOST_LINES: Final = 12
_ARENA, _HUNTERS, _TARGETS, _PREY = range(4)
"""Indices of the parts of a state, in the order of `StateParts`."""


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
    tables = (ARENA, HUNTER, target_numbers(config), PREY)
    first_rows, second_rows = _rows(first, config), _rows(second, config)
    for group, number in sorted(first_rows.keys() | second_rows.keys()):
        subject = _body_name(config, names, group, number)
        first_row, second_row = (rows.get((group, number)) for rows in (first_rows, second_rows))
        if first_row is None or second_row is None:
            here, there = labels[::-1] if first_row is None else labels
            found.append(f"{subject}: alive {here}, not {there}")
            continue
        for (quantity, unit), *values in zip(tables[group].items(), first_row, second_row, strict=True):
            if values[0] != values[1]:
                shown = [f"{_shown(config, unit, value)} {label}" for value, label in zip(values, labels, strict=True)]
                found.append(f"{subject}: {quantity} is {' and '.join(shown)}{_apart(quantity, unit, values)}")
    return found or ["every number differs by less than a millionth of its unit"]


def _rows(state: QuantisedState, config: ArenaConfig) -> dict[tuple[int, int], list[int]]:
    """Return the numbers of the arena, each agent and each target by (part of the state, seat, index or number)."""
    found = {}
    for group, part in enumerate(parts_of(state, config)):
        for place, row in enumerate(part.tolist()):
            found[group, row[0] if group == _TARGETS else place] = row
    return found


def _body_name(config: ArenaConfig, names: Sequence[str], group: int, number: int) -> str:
    if group == _ARENA:
        return "clock and counters"
    if group == _TARGETS:
        return config.target_name(number)
    agent = number if group == _HUNTERS else config.hunters + number
    name = (config.hunter_names + config.prey_names)[agent]
    return name if name == names[agent] else f"{name} ({names[agent]})"


def _apart(quantity: str, unit: str, values: Sequence[int]) -> str:
    """Return the difference of two values in words; "" if it has no meaning."""
    if unit in ("target", "flag") or (unit == OUT and min(values) < 0):
        return ""
    apart = abs(values[1] - values[0])
    if quantity == "theta":
        return f", {math.fabs(wrap(apart / 1e6)):.6f} rad apart"
    return f", {f'{apart / 1e6:.6f} {unit}' if unit in MICRO else f'{apart} {unit[:2]}'.strip()} apart"


def _shown(config: ArenaConfig, unit: str, value: int) -> str:
    if unit in MICRO:
        return f"{value / 1e6:.6f} {unit}"
    if unit == "target":
        return config.target_name(value) if value else "none"
    if unit == "flag":
        return "yes" if value else "no"
    if unit == OUT and value < 0:
        return "not out"
    return f"{value} {unit[:2]}".strip()
