"""Comparison of two replays: the first differences."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from catch_arena.config import ArenaConfig
from catch_arena.replay.recording import Replay
from catch_arena.replay.states import MICRO, QuantisedState, parts_of, scores, tables_of

_MOST_LINES: Final = 12


def replay_differences(first: Replay, second: Replay) -> list[str]:
    """Return a line for each difference of two replays: of headers, first actions, first state with its numbers, and
    scores; [] for equal replays. The recorded data are compared; `verification.verify` checks them.
    """
    headers = _header(first), _header(second)
    found = []
    for name in headers[0] | headers[1]:
        values = [header.get(name, "none") for header in headers]
        if values[0] != values[1]:
            found.append(f"{name}: {values[0]} in A; {values[1]} in B")
    for kind in ("hunters", "prey", "targets_move"):
        if getattr(first.config, kind) != getattr(second.config, kind):
            return [*found, f"with different {kind}, actions and states cannot be compared"]
    found += _first_actions(first, second)
    found += first_states(first, second, ("in A", "in B"))
    if first.steps != second.steps:
        found.append(f"steps: {first.steps} in A; {second.steps} in B")
    if found:
        results = (scores(match.states[-1], match.config) for match in (first, second))
        for kind, one, other in zip(("scores of the hunters", "catches of each prey"), *results, strict=True):
            if one:
                found.append(f"final {kind}: {', '.join(map(str, one))} in A; {', '.join(map(str, other))} in B")
    return found


def _header(replay: Replay) -> dict[str, str]:
    """Return the entries of a replay's header in words, by name: seed, title, agents, and settings."""
    agents = replay.config.hunter_names + replay.config.prey_names
    return {
        "seed": str(replay.seed),
        "title": repr(replay.title),
        **{f"the agent of {agent}": repr(name) for agent, name in zip(agents, replay.names, strict=True)},
        **{name: str(value) for name, value in sorted(flat_settings(replay.config).items())},
    }


def flat_settings(config: ArenaConfig) -> dict[str, Any]:
    """Return the settings as one table, with groups as single entries: `gains` becomes `gains.kp_v` and so on."""
    flat: dict[str, Any] = {}
    for name, value in config.to_dict().items():
        parts = value.items() if isinstance(value, dict) else None
        flat |= {name: value} if parts is None else {f"{name}.{part}": number for part, number in parts}
    return flat


def _first_actions(first: Replay, second: Replay) -> list[str]:
    """Return the differences of actions and withdrawals in the first step that has any; [] if there are none."""
    agents = first.config.hunter_names + first.config.prey_names
    steps = min(first.steps, second.steps)
    for step in range(steps + 1):
        gone = [set(match.withdrawn_before(step)) for match in (first, second)]
        found = [
            f"before step {step + 1}: {agents[agent]} is withdrawn in {'A' if agent in gone[0] else 'B'} only"
            for agent in sorted(gone[0] ^ gone[1])
        ]
        for index, agent in enumerate(agents if step < steps else ()):
            first_action, second_action = (_action(match, step, index) for match in (first, second))
            if first_action != second_action:
                found.append(f"step {step + 1}: {agent} acts differently: {first_action} in A; {second_action} in B")
        if found:
            return found
    return []


def _action(replay: Replay, step: int, agent: int) -> str:
    """Return an agent's action in a step, counted from 0; prey are numbered after the hunters."""
    if agent >= replay.config.hunters:
        return replay.prey_action(step, agent - replay.config.hunters)
    named = ", ".join(replay.requested_by_name(step, agent))
    return replay.action(step, agent) + (f" ({named})" if named else "")


def first_states(first: Replay, second: Replay, labels: tuple[str, str]) -> list[str]:
    """Return a line that names the first states that differ, and lines with their numbers; [] if all states agree.

    Args:
        first: the first match.
        second: the second match, with as many hunters and prey.
        labels: the names of the two matches in the lines.
    """
    recorded = zip(first.digests, second.digests, first.states, second.states, strict=False)
    differ = [
        step
        for step, (*digests, one, other) in enumerate(recorded)
        if digests[0] != digests[1] or not np.array_equal(one, other)
    ]
    if not differ:
        return []
    step, last = differ[0], differ[-1]
    ends = last + 1 == min(len(first.states), len(second.states))
    again = "" if ends else f"; from {state_name(last + 1)} on they agree"
    if first.digests[step] == second.digests[step]:
        again = f", although their digests agree{again}"
    agents = zip(first.config.hunter_names + first.config.prey_names, first.names, second.names, strict=True)
    names = [name if name == twin else agent for agent, name, twin in agents]
    lines = _state_differences(first.config, names, first.states[step], second.states[step], labels)
    return [f"the states first differ in {state_name(step)}{again}", *(f"{state_name(step)}: {line}" for line in lines)]


def state_name(step: int) -> str:
    """Return the name of the state after `step` steps."""
    return "the initial state" if step == 0 else f"step {step}"


def _state_differences(
    config: ArenaConfig,
    names: Sequence[str],
    first: QuantisedState,
    second: QuantisedState,
    labels: tuple[str, str],
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
