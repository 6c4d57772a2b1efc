"""Comparison of two replays: the first differences."""

from collections.abc import Iterator
from itertools import zip_longest
from typing import Any

import numpy as np

from catch_arena.config import ArenaConfig
from catch_arena.replay.recording import Replay
from catch_arena.replay.state_differences import first_lines, state_differences, state_name
from catch_arena.replay.states import scores


def replay_differences(one: Replay, other: Replay) -> list[str]:
    """Return a line for each difference of two replays: of headers, first actions, first state with its numbers, and
    scores; [] for equal replays. The recorded data are compared; `verification.verify` checks them.
    """
    found = [f"{name}: {ours} in A, {theirs} in B" for name, ours, theirs in _headers(one, other)]
    for what in ("hunters", "prey"):
        if getattr(one.config, what) != getattr(other.config, what):
            return [*found, f"with different numbers of {what}, actions and states cannot be compared"]
    steps = min(one.steps, other.steps)
    found += _first_actions(one, other, steps)
    if one.config.targets_move == other.config.targets_move:
        found += _first_state(one, other, steps)
    else:
        found.append(f"targets move in {'A' if one.config.targets_move else 'B'} only, so states are not compared")
    if one.steps != other.steps:
        found.append(f"steps: {one.steps} in A, {other.steps} in B")
    if found:
        ours, theirs = (scores(each.states[-1], each.config) for each in (one, other))
        for what, *results in zip(("final scores", "number of catches of each prey"), ours, theirs, strict=True):
            if results[0]:
                shown = [", ".join(map(str, result)) for result in results]
                same = "the same in both" if shown[0] == shown[1] else f"in A, {shown[1]} in B"
                found.append(f"{what}: {shown[0]} {same}")
    return found


def _headers(one: Replay, other: Replay) -> Iterator[tuple[str, Any, Any]]:
    """Yield each difference of the headers as (name, ours, theirs)."""
    for name in ("seed", "title"):
        if getattr(one, name) != getattr(other, name):
            yield name, repr(getattr(one, name)), repr(getattr(other, name))
    for side, ours, theirs in (
        ("hunter", one.hunter_names, other.hunter_names),
        ("prey", one.prey_names, other.prey_names),
    ):
        for place, names in enumerate(zip_longest(ours, theirs)):
            if names[0] != names[1]:
                yield f"the agent of {side}_{place}", repr(names[0]), repr(names[1])
    settings, others = ({**flat_settings(each.config), "control": None} for each in (one, other))
    for name in sorted(settings.keys() | others.keys()):
        if settings.get(name) != others.get(name):
            yield name, settings.get(name), others.get(name)
    for seat, controls in enumerate(zip_longest(one.config.controls, other.config.controls)):
        if controls[0] != controls[1]:
            yield f"control of hunter_{seat}", *controls


def flat_settings(config: ArenaConfig) -> dict[str, Any]:
    """Return the settings as one table, with groups as single entries: `gains` becomes `gains.kp_v` and so on."""
    flat: dict[str, Any] = {}
    for name, value in config.to_dict().items():
        parts = value.items() if isinstance(value, dict) else None
        flat |= {name: value} if parts is None else {f"{name}.{part}": number for part, number in parts}
    return flat


def _first_actions(one: Replay, other: Replay, steps: int) -> list[str]:
    """Return the differences of actions and withdrawals in the first step that has any; [] if there are none."""
    agents = one.config.hunter_names + one.config.prey_names
    for step in range(steps + 1):
        gone = [set(each.withdrawn_before(step)) for each in (one, other)]
        found = [
            f"before step {step + 1}: {agents[agent]} is withdrawn in {'A' if agent in gone[0] else 'B'} only"
            for agent in sorted(gone[0] ^ gone[1])
        ]
        for agent, ours, theirs in zip(agents, *(_actions(each, step) for each in (one, other)), strict=False):
            if ours != theirs:
                found.append(f"step {step + 1}: {agent} acts differently: {ours} in A, {theirs} in B")
        if found:
            return found
    return []


def _actions(replay: Replay, step: int) -> list[str]:
    """Return each agent's action in a step, counted from 0; [] after the last step."""
    if step == replay.steps:
        return []
    hunters = []
    for seat in range(replay.config.hunters):
        named = ", ".join(replay.asked_by_name(step, seat))
        hunters.append(" ".join(filter(None, (replay.action(step, seat), named and f"({named})"))))
    return hunters + [replay.prey_action(step, index) for index in range(replay.config.prey)]


def _first_state(one: Replay, other: Replay, steps: int) -> list[str]:
    agents = one.config.hunter_names + one.config.prey_names
    for step in range(steps + 1):
        ours, theirs = one.states[step], other.states[step]
        if one.digests[step] != other.digests[step] or not np.array_equal(ours, theirs):
            names = [
                name if name == twin else seat for name, twin, seat in zip(one.names, other.names, agents, strict=True)
            ]
            lines = state_differences(one.config, names, ours, theirs, ("in A", "in B"))
            return [f"{state_name(step)} is the first difference", *first_lines(step, lines)]
    return []
