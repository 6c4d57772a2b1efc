"""Two states of a match, number by number, in words."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.core.math import wrap
from catch_arena.replay.quantisation import ARENA, HUNTER, PREY, Matrix, QuantisedState, parts_of, target_numbers

_FLAGS: Final = ("at wall", "withdrawn")
_TARGETS: Final = ("active target", "target")
_CAUGHT_AT: Final = "caught at"
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
        names: the agents', of the hunters by seat and of the prey by index.
        one: the first.
        other: the second.
        labels: what the states are called.
    """
    found = list(_differing(config, names, one, other, labels))
    return found or ["every number by less than a millionth of its unit"]


def _differing(
    config: ArenaConfig, names: Sequence[str], one: QuantisedState, other: QuantisedState, labels: tuple[str, str]
) -> Iterator[str]:
    arenas, hunters, targets, prey = zip(parts_of(one, config), parts_of(other, config), strict=True)
    hunter_names, prey_names = names[: config.hunters], names[config.hunters :]
    yield from _of_each(config, ["clock and counters"], dict.fromkeys(ARENA, ""), arenas, labels)
    yield from _of_each(config, _called(config.hunter_names, hunter_names), HUNTER, hunters, labels)
    units = target_numbers(config)
    ours, theirs = ({row[0]: row for row in rows.tolist()} for rows in targets)
    for number in sorted(ours.keys() | theirs.keys()):
        name = config.target_name(number)
        if number not in ours or number not in theirs:
            here, there = labels if number in ours else labels[::-1]
            yield f"{name}: alive {here}, not {there}"
            continue
        for (what, unit), *values in zip(units.items(), ours[number], theirs[number], strict=True):
            if values[0] != values[1]:
                yield f"{name}: {_compared(config, what, unit, values, labels)}"
    yield from _of_each(config, _called(config.prey_names, prey_names), dict.fromkeys(PREY, ""), prey, labels)


def _called(agents: Sequence[str], names: Sequence[str]) -> list[str]:
    return [agent if name == agent else f"{agent} ({name})" for agent, name in zip(agents, names, strict=True)]


def _of_each(
    config: ArenaConfig,
    called: Sequence[str],
    units: Mapping[str, str],
    tables: tuple[Matrix, Matrix],
    labels: tuple[str, str],
) -> Iterator[str]:
    """What differs in two tables that have a row for each that is called so, and a column for each number."""
    for who, *rows in zip(called, *(table.tolist() for table in tables), strict=True):
        for (what, unit), *values in zip(units.items(), *rows, strict=True):
            if values[0] != values[1]:
                yield f"{who}: {_compared(config, what, unit, values, labels)}"


def _compared(config: ArenaConfig, what: str, unit: str, values: list[int], labels: tuple[str, str]) -> str:
    shown = " and ".join(
        f"{_shown(config, what, unit, value)} {word}" for value, word in zip(values, labels, strict=True)
    )
    if what in _TARGETS or what in _FLAGS or (what == _CAUGHT_AT and min(values) < 0):
        return f"{what} is {shown}"
    apart = values[1] - values[0]
    if what == "theta":
        return f"{what} is {shown}, {math.fabs(wrap(apart / 1e6)):.6f} rad apart"
    return f"{what} is {shown}, {_shown(config, what, unit, abs(apart))} apart"


def _shown(config: ArenaConfig, what: str, unit: str, value: int) -> str:
    if unit:
        return f"{value / 1e6:.6f} {unit}"
    if what in _TARGETS:
        return config.target_name(value) if value else "none"
    if what in _FLAGS:
        return "yes" if value else "no"
    if what == _CAUGHT_AT and value < 0:
        return "not out"
    return f"{value} ms" if what in {"time", "appeared", _CAUGHT_AT} else str(value)
