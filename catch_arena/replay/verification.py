"""R10.2: check that a match plays as it was recorded, and report the altered parts if it does not."""

from collections.abc import Callable, Sequence
from itertools import groupby

import numpy as np

from catch_arena.errors import ReplayError
from catch_arena.replay.named_requests import requests_of_step
from catch_arena.replay.recording import Replay
from catch_arena.replay.state_differences import first_lines, on_one_line, state_differences, state_name
from catch_arena.world import World


def verify(replay: Replay, progress: Callable[[int, int], None] | None = None) -> list[str]:
    """Play a match again and return all differences; an empty list proves the replay.

    Each state follows from the one before. So if the digests differ from some step to the end, the match itself
    differs: in an action, a setting or a rule. If a digest differs although all later ones agree, it was altered in the
    file. If a quantised state differs although its digest agrees, the state was altered.

    With prey, a match can differ in some steps only: the place of prey has no effect any more when it has been caught
    and returned. Then both the numbers and the digests differ.

    Args:
        replay: the recorded match.
        progress: called with (steps played, number of steps).

    Returns:
        a line for each fault; if the match differs, further lines for the numbers that differ in its first such step.
    """
    played = Replay(replay.config, replay.seed, replay.names)
    impossible: list[str] = []
    before: World | None = None
    for step, engine in enumerate(replay.engines()):
        played.note(engine)
        if engine.ends.item() and step < replay.steps:
            impossible.append(f"the match ends in {state_name(step)}, but {replay.steps} steps are recorded")
        if before is not None:
            try:
                replay.named_rulings(before, engine.world())
            except ReplayError as error:
                impossible.append(str(error))
        before = engine.world() if requests_of_step(replay.named_requests, step) else None
        if progress is not None:
            progress(step, replay.steps)
    return [*impossible[:1], *_faults(replay, played)]


def _faults(replay: Replay, played: Replay) -> list[str]:
    """Return the faults that follow from the steps whose digests or numbers differ."""
    steps = range(replay.steps + 1)
    other_digests = [step for step in steps if replay.digests[step] != played.digests[step]]
    other_numbers = {step for step in steps if not np.array_equal(replay.states[step], played.states[step])}
    stretches = [[step for _, step in run] for _, run in groupby(enumerate(other_digests), lambda at: at[1] - at[0])]
    differs, altered = [], []
    for stretch in stretches:
        rejoined = replay.config.prey and not other_numbers.isdisjoint(stretch)
        if rejoined or stretch[-1] == replay.steps:
            differs.append(stretch)
        else:
            altered += stretch
    found = [f"{_altered('digest', altered)}: the match itself plays as recorded"] if altered else []
    if numbers := sorted(other_numbers.difference(other_digests)):
        difference = on_one_line(_differences(replay, played, numbers[0]))
        found.append(f"{_altered('quantised state', numbers)}: the digest agrees, but {difference}")
    for stretch in differs:
        first, last = stretch[0], stretch[-1]
        again = "" if last == replay.steps else f"; from {state_name(last + 1)} on it plays as recorded"
        found.append(f"the first difference is in {state_name(first)}{again}")
        found += first_lines(first, _differences(replay, played, first))
    return found


def _differences(replay: Replay, played: Replay, step: int) -> list[str]:
    return state_differences(replay.config, replay.names, replay.states[step], played.states[step])


def _altered(kind: str, steps: Sequence[int]) -> str:
    later = len(steps) - 1
    also = f", and those of {later} later {'step' if later == 1 else 'steps'}" if later else ""
    return f"{state_name(steps[0])}: its {kind} was altered{also}"
