"""Two states of a match, number by number, in words."""

import math
from collections.abc import Iterator, Sequence
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.core.math import wrap
from catch_arena.replay.quantisation import ARENA, HUNTER, QuantisedState, target_numbers

_FLAGS: Final = ("at wall", "withdrawn")
_MOST_LINES: Final = 12


def state_name(step: int) -> str:
    """What the state is called that a step led to, or that stood before the first one."""
    return "the initial state" if step == 0 else f"step {step}"


def on_one_line(differences: Sequence[str]) -> str:
    """The first of them, and how many more there are."""
    more = f" (and {len(differences) - 1} more)" if len(differences) > 1 else ""
    return f"{differences[0]}{more}"


def first_lines(step: int, differences: Sequence[str]) -> list[str]:
    """A line for each of the first ones, with the step, and how many more there are."""
    shown = [f"{state_name(step)}: {line}" for line in differences[:_MOST_LINES]]
    more = len(differences) - _MOST_LINES
    return [*shown, f"{state_name(step)}: and {more} more"] if more > 0 else shown


def state_differences(
    config: ArenaConfig,
    names: Sequence[str],
    one: QuantisedState,
    other: QuantisedState,
    labels: tuple[str, str] = ("as recorded", "as replayed"),
) -> list[str]:
    """In what two states of an arena differ whose digests do: a line for each number, at least one line.

    Args:
        config: the arena's settings.
        names: the agents' by seat.
        one: the first.
        other: the second.
        labels: what the states are called.
    """
    found = list(_differing(config, names, one.tolist(), other.tolist(), labels))
    return found or ["every number by less than a millionth of its unit"]


def _differing(
    config: ArenaConfig, names: Sequence[str], one: list[int], other: list[int], labels: tuple[str, str]
) -> Iterator[str]:
    size = len(HUNTER)
    first = len(ARENA)
    end = first + config.hunters * size
    for what, *values in zip(ARENA, one[:first], other[:first], strict=True):
        if values[0] != values[1]:
            yield f"clock and counters: {_compared(config, what, '', values, labels)}"
    for seat, name in enumerate(names):
        at = first + seat * size
        who = f"hunter_{seat}" if name == f"hunter_{seat}" else f"hunter_{seat} ({name})"
        for (what, unit), *values in zip(HUNTER.items(), one[at : at + size], other[at : at + size], strict=True):
            if values[0] != values[1]:
                yield f"{who}: {_compared(config, what, unit, values, labels)}"
    units = target_numbers(config)
    ours, theirs = (_by_number(state[end:], len(units)) for state in (one, other))
    for number in sorted(ours.keys() | theirs.keys()):
        name = config.target_name(number)
        if number not in ours or number not in theirs:
            here, there = labels if number in ours else labels[::-1]
            yield f"{name}: alive {here}, not {there}"
            continue
        for (what, unit), *values in zip(units.items(), ours[number], theirs[number], strict=True):
            if values[0] != values[1]:
                yield f"{name}: {_compared(config, what, unit, values, labels)}"


def _by_number(numbers: list[int], size: int) -> dict[int, list[int]]:
    """The targets of a state, which have so many numbers each."""
    return {numbers[at]: numbers[at : at + size] for at in range(0, len(numbers), size)}


def _compared(config: ArenaConfig, what: str, unit: str, values: list[int], labels: tuple[str, str]) -> str:
    shown = " and ".join(
        f"{_shown(config, what, unit, value)} {word}" for value, word in zip(values, labels, strict=True)
    )
    if what == "active target" or what in _FLAGS:
        return f"{what} is {shown}"
    apart = values[1] - values[0]
    if what == "theta":
        return f"{what} is {shown}, {math.fabs(wrap(apart / 1e6)):.6f} rad apart"
    return f"{what} is {shown}, {_shown(config, what, unit, abs(apart))} apart"


def _shown(config: ArenaConfig, what: str, unit: str, value: int) -> str:
    if unit:
        return f"{value / 1e6:.6f} {unit}"
    if what == "active target":
        return config.target_name(value) if value else "none"
    if what in _FLAGS:
        return "yes" if value else "no"
    return f"{value} ms" if what in {"time", "appeared"} else str(value)
