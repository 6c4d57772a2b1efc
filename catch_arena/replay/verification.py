"""R10.2: check that a match plays as it was recorded, and report the first difference if it does not."""

from collections.abc import Callable

from catch_arena.replay.recording import Replay, state_name


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
