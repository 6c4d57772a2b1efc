"""R10.2: check that a match plays as it was recorded, and report the first difference if it does not."""

from collections.abc import Callable

from catch_arena.replay.comparison import first_states, state_name
from catch_arena.replay.recording import Replay


def verify(replay: Replay, progress: Callable[[int, int], None] | None = None) -> list[str]:
    """Play a match again and return all differences; an empty list proves the replay.

    Each state follows from the one before. So if the states differ from some step to the end, the match itself differs:
    in an action, a setting or a rule. If later states agree again, a digest or a number was altered in the file, or,
    with prey, it was caught and returned: where it had been has no effect after that.

    Args:
        replay: the recorded match.
        progress: called with (steps played, number of steps).

    Returns:
        a line for each fault; if states differ, a line for the first one, and lines for the numbers that differ in it.
    """
    played = Replay(replay.config, replay.seed, replay.names)
    found: list[str] = []
    for step, engine in enumerate(replay.engines()):
        played.note(engine)
        if not found and engine.ends.item() and step < replay.steps:
            found = [f"the match ends in {state_name(step)}, but {replay.steps} steps are recorded"]
        if progress is not None:
            progress(step, replay.steps)
    return found + first_states(replay, played, ("as recorded", "as replayed"))
