"""Comparison of two replays: the first differences."""

from typing import Any

import numpy as np

from catch_arena.config import ArenaConfig
from catch_arena.replay.recording import Replay
from catch_arena.replay.state_differences import first_lines, state_differences, state_name
from catch_arena.replay.states import scores


def replay_differences(first: Replay, second: Replay) -> list[str]:
    """Return a line for each difference of two replays: of headers, first actions, first state with its numbers, and
    scores; [] for equal replays. The recorded data are compared; `verification.verify` checks them.
    """
    headers = _header(first), _header(second)
    found = []
    for name in headers[0] | headers[1]:
        first_value, second_value = (header.get(name, "none") for header in headers)
        if first_value != second_value:
            found.append(f"{name}: {first_value} in A; {second_value} in B")
    for kind in ("hunters", "prey"):
        if getattr(first.config, kind) != getattr(second.config, kind):
            return [*found, f"with different numbers of {kind}, actions and states cannot be compared"]
    steps = min(first.steps, second.steps)
    found += _first_actions(first, second, steps)
    if first.config.targets_move == second.config.targets_move:
        found += _first_state(first, second, steps)
    else:
        found.append(f"targets move in {'A' if first.config.targets_move else 'B'} only, so states are not compared")
    if first.steps != second.steps:
        found.append(f"steps: {first.steps} in A; {second.steps} in B")
    if found:
        first_values, second_values = (scores(match.states[-1], match.config) for match in (first, second))
        for kind, *results in zip(
            ("final scores", "number of catches of each prey"), first_values, second_values, strict=True
        ):
            if results[0]:
                shown = [", ".join(map(str, result)) for result in results]
                same = "the same in both" if shown[0] == shown[1] else f"in A; {shown[1]} in B"
                found.append(f"{kind}: {shown[0]} {same}")
    return found


def _header(replay: Replay) -> dict[str, str]:
    """Return the entries of a replay's header in words, by name: seed, title, agents, settings and controls."""
    config, settings = replay.config, flat_settings(replay.config)
    del settings["control"]
    agents = config.hunter_names + config.prey_names
    return {
        "seed": str(replay.seed),
        "title": repr(replay.title),
        **{f"the agent of {agent}": repr(name) for agent, name in zip(agents, replay.names, strict=True)},
        **{name: str(settings[name]) for name in sorted(settings)},
        **{f"control of {agent}": control for agent, control in zip(agents, config.controls, strict=False)},
    }


def flat_settings(config: ArenaConfig) -> dict[str, Any]:
    """Return the settings as one table, with groups as single entries: `gains` becomes `gains.kp_v` and so on."""
    flat: dict[str, Any] = {}
    for name, value in config.to_dict().items():
        parts = value.items() if isinstance(value, dict) else None
        flat |= {name: value} if parts is None else {f"{name}.{part}": number for part, number in parts}
    return flat


def _first_actions(first: Replay, second: Replay, steps: int) -> list[str]:
    """Return the differences of actions and withdrawals in the first step that has any; [] if there are none."""
    agents = first.config.hunter_names + first.config.prey_names
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


def _first_state(first: Replay, second: Replay, steps: int) -> list[str]:
    agents = first.config.hunter_names + first.config.prey_names
    for step in range(steps + 1):
        first_state, second_state = first.states[step], second.states[step]
        if first.digests[step] != second.digests[step] or not np.array_equal(first_state, second_state):
            names = [
                name if name == twin else seat
                for name, twin, seat in zip(first.names, second.names, agents, strict=True)
            ]
            lines = state_differences(first.config, names, first_state, second_state, ("in A", "in B"))
            return [f"the states first differ in {state_name(step)}", *first_lines(step, lines)]
    return []
