"""Comparison of two replays: the first differences."""

from collections.abc import Iterator
from itertools import zip_longest
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
    found = [
        f"{name}: {first_values} in A; {second_values} in B"
        for name, first_values, second_values in _headers(first, second)
    ]
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


def _headers(first: Replay, second: Replay) -> Iterator[tuple[str, Any, Any]]:
    """Yield each difference of the headers as (name, value of the first replay, value of the second)."""
    for name in ("seed", "title"):
        if getattr(first, name) != getattr(second, name):
            yield name, repr(getattr(first, name)), repr(getattr(second, name))
    for side, first_values, second_values in (
        ("hunter", first.hunter_names, second.hunter_names),
        ("prey", first.prey_names, second.prey_names),
    ):
        for place, names in enumerate(zip_longest(first_values, second_values)):
            if names[0] != names[1]:
                first_name, second_name = ("none" if name is None else repr(name) for name in names)
                yield f"the agent of {side}_{place}", first_name, second_name
    settings, second_settings = ({**flat_settings(match.config), "control": None} for match in (first, second))
    for name in sorted(settings.keys() | second_settings.keys()):
        if settings.get(name) != second_settings.get(name):
            yield name, settings.get(name), second_settings.get(name)
    for seat, controls in enumerate(zip_longest(first.config.controls, second.config.controls, fillvalue="none")):
        if controls[0] != controls[1]:
            yield f"control of hunter_{seat}", *controls


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
        for agent, first_action, second_action in zip(
            agents, *(_actions(match, step) for match in (first, second)), strict=False
        ):
            if first_action != second_action:
                found.append(f"step {step + 1}: {agent} acts differently: {first_action} in A; {second_action} in B")
        if found:
            return found
    return []


def _actions(replay: Replay, step: int) -> list[str]:
    """Return each agent's action in a step, counted from 0; [] after the last step."""
    if step == replay.steps:
        return []
    hunters = []
    for seat in range(replay.config.hunters):
        named = ", ".join(replay.requested_by_name(step, seat))
        hunters.append(" ".join(filter(None, (replay.action(step, seat), named and f"({named})"))))
    return hunters + [replay.prey_action(step, index) for index in range(replay.config.prey)]


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
