"""Comparison of a replay with the match as it plays again (R10.2), and of two replays with each other."""

from collections.abc import Callable, Iterable
from itertools import chain
from typing import Any, Final

from catch_arena.replay.recording import Replay, state_name
from catch_arena.world import HunterState, PreyState, TargetState, World

_MOST_LINES: Final = 12


def verify(replay: Replay, progress: Callable[[int, int], None] | None = None) -> list[str]:
    """Play a match again and return all differences; an empty list proves the replay.

    Each state follows from the one before. So if the states differ from some step to the end, the match itself differs:
    in an action, a setting or a rule. If later states agree again, a digest was altered in the file, or, with prey, it
    was caught and returned: where it had been has no effect after that.

    Args:
        replay: the recorded match.
        progress: called with (steps played, number of steps).

    Returns:
        a line for each fault.
    """
    found: list[str] = []
    differ: list[int] = []
    for step, engine in enumerate(replay.engines()):
        if engine.digest() != replay.digests[step]:
            differ.append(step)
        if not found and engine.ends.item() and step < replay.steps:
            found = [f"the match ends in {state_name(step)}, but {replay.steps} steps are recorded"]
        if progress is not None:
            progress(step, replay.steps)
    if differ:
        again = "" if differ[-1] == replay.steps else f"; from {state_name(differ[-1] + 1)} on they agree"
        found.append(f"the states first differ in {state_name(differ[0])}{again}")
    return found


def replay_differences(first: Replay, second: Replay) -> list[str]:
    """Return a line for each difference of two replays: of headers, first actions, first state with its numbers, and
    scores; [] for equal replays. `verify` checks that each plays as recorded.
    """
    if first == second:
        return []
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
    states: list[str] = []
    playing = first.engines(), second.engines()
    for step, (one, other) in enumerate(zip(*playing, strict=False)):
        if not states and (first.digests[step], one.digest()) != (second.digests[step], other.digest()):
            states = _different_states(first, second, step, (one.world(), other.world()))
    found += states
    if first.steps != second.steps:
        found.append(f"steps: {first.steps} in A; {second.steps} in B")
    if found:
        for _ in chain(*playing):  # the longer match goes on to its end
            pass
        worlds = one.world(), other.world()
        of_hunters = ([hunter.score for hunter in world.hunters] for world in worlds)
        of_prey = ([prey.times_caught for prey in world.prey] for world in worlds)
        for kind, (here, there) in (("scores of the hunters", of_hunters), ("catches of each prey", of_prey)):
            if here:
                found.append(f"final {kind}: {', '.join(map(str, here))} in A; {', '.join(map(str, there))} in B")
    return found


def _header(replay: Replay) -> dict[str, str]:
    """Return the entries of a replay's header in words, by name: seed, title, agents, and settings."""
    agents = replay.config.hunter_names + replay.config.prey_names
    return {
        "seed": str(replay.seed),
        "title": repr(replay.title),
        **{f"the agent of {agent}": repr(name) for agent, name in zip(agents, replay.names, strict=True)},
        **{name: str(value) for name, value in sorted(replay.config.to_flat_dict().items())},
    }


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
            first_action, second_action = (match.action(step, index) for match in (first, second))
            if first_action != second_action:
                found.append(f"step {step + 1}: {agent} acts differently: {first_action} in A; {second_action} in B")
        if found:
            return found
    return []


def _different_states(first: Replay, second: Replay, step: int, worlds: Iterable[World]) -> list[str]:
    """Return a line that names the states after `step` steps, which differ, and lines with their numbers."""
    agents = zip(first.config.hunter_names + first.config.prey_names, first.names, second.names, strict=True)
    labels = {agent: f"{agent} ({name})" for agent, name, twin in agents if agent != name == twin}
    here, there = map(_bodies, worlds)
    found = []
    for kind, name in here | there:
        body, twin = here.get((kind, name)), there.get((kind, name))
        label = name if kind is TargetState else labels.get(name, name)
        if body is None or twin is None:
            found.append(f"{label}: in {'B' if body is None else 'A'} only")
            continue
        for quantity, value in body.items():
            other = twin[quantity]
            if value != other:
                found.append(f"{label}: {quantity} is {value} in A and {other} in B")
    if not found:
        found = ["all positions and scores are equal; counters, controllers' integrals or digests differ"]
    if len(found) > _MOST_LINES:
        found[_MOST_LINES:] = [f"{len(found) - _MOST_LINES} more"]
    name = state_name(step)
    return [f"the states first differ in {name}", *(f"{name}: {line}" for line in found)]


def _bodies(world: World) -> dict[tuple[type, str], dict[str, Any]]:
    """Return the quantities of the arena and of each hunter, target and prey, by kind and name."""
    bodies: tuple[HunterState | TargetState | PreyState, ...] = (*world.hunters, *world.targets, *world.prey)
    found = {(type(body), body.name): body._asdict() for body in bodies}
    return {(World, "the arena"): {"time_ms": world.time_ms, "spawned": world.spawned}, **found}
