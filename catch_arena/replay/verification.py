"""R10.2: whether a match plays as it was recorded, and if not, what was altered."""

from collections.abc import Callable, Sequence

import numpy as np

from catch_arena.replay.quantisation import QuantisedState, quantise
from catch_arena.replay.recording import Replay
from catch_arena.replay.state_differences import first_lines, on_one_line, state_differences, state_name


def verify(replay: Replay, progress: Callable[[int, int], None] | None = None) -> list[str]:
    """Play a match again and say all that does not fit; an empty list is a proof.

    A state follows from the one before. So where the digests differ from some step to the end, the match itself
    differs: an action, a setting or a rule is another one. A step whose digest differs although all later ones agree
    was altered in the file, and so was a quantised state where the digest agrees.

    With prey a match can differ for some steps alone: where prey was does not matter any more when it has been caught
    and returned. Then the numbers differ as well as the digests.

    Args:
        replay: the recorded match.
        progress: called with (steps played, steps in all).

    Returns:
        a line for each fault; where a match differs, a further line for each number that does in the first step.
    """
    digests: list[int] = []  # steps whose digest was altered
    numbers: list[int] = []  # steps whose numbers were
    parted: list[tuple[int, QuantisedState, int]] = []  # the match differed: from, what was replayed there, until
    since: int | None = None  # the step from which on the digests differ
    apart = False  # whether the numbers have differed too since then
    then = there = np.zeros(0, dtype=np.int64)  # what was replayed there, and at the first altered numbers
    for step, engine in enumerate(replay.engines()):
        state = quantise(engine.state(), replay.config)
        if engine.digest() != replay.digests[step]:
            if since is None:
                since, then, apart = step, state, False
            apart |= not np.array_equal(state, replay.states[step])
        else:
            if since is not None and apart and replay.config.prey:
                parted.append((since, then, step))
            elif since is not None:
                digests += range(since, step)
            since = None
            if not np.array_equal(state, replay.states[step]):
                there = there if numbers else state
                numbers.append(step)
        if progress is not None:
            progress(step, replay.steps)

    def differences(step: int, state: QuantisedState) -> list[str]:
        return state_differences(replay.config, replay.names, replay.states[step], state)

    found = []
    if digests:
        found.append(f"{_altered('digest', digests)}: the match plays on as recorded")
    if numbers:
        difference = on_one_line(differences(numbers[0], there))
        found.append(f"{_altered('quantised state', numbers)}: the digest agrees, but {difference}")
    for first, replayed, until in parted:
        found.append(f"{state_name(first)} is the first that differs; from {state_name(until)} on it plays as recorded")
        found += first_lines(first, differences(first, replayed))
    if since is not None:
        found.append(f"{state_name(since)} is the first that differs")
        found += first_lines(since, differences(since, then))
    return found


def _altered(what: str, steps: Sequence[int]) -> str:
    later = len(steps) - 1
    also = f", and that of {later} later {'step' if later == 1 else 'steps'}" if later else ""
    return f"{state_name(steps[0])}: its {what} was altered{also}"
