"""Matches that are kept: recorded, saved, loaded, played again, checked and compared (docs/replays.md).

- recording: a match is recorded: `Replay`. fileformat: as a file, with states (their numbers in whole millionths) and
  codec (columns of whole numbers as bytes). named_requests: what was asked for by name, and judged again.
- verification: checks if a match plays as recorded. comparison: where two matches part. state_differences: in which
  numbers. motion: where everybody is between two states.
"""

from catch_arena.replay.fileformat import checked_names, checked_text
from catch_arena.replay.recording import Replay

__all__ = ["Replay", "checked_names", "checked_text"]
