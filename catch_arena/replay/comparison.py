"""Comparison of two replays: the first differences."""

from typing import Any

import numpy as np

from catch_arena.config import ArenaConfig
from catch_arena.replay.recording import Replay
from catch_arena.replay.state_differences import state_differences, state_name
from catch_arena.replay.states import scores


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
    lines = state_differences(first.config, names, first.states[step], second.states[step], labels)
    return [f"the states first differ in {state_name(step)}{again}", *(f"{state_name(step)}: {line}" for line in lines)]
