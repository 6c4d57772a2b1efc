"""Replays: matches that are recorded, saved, loaded, played again, checked and compared (docs/reference/replays.md).

- recording: `Replay`, a recorded match. fileformat: its file, with states (numbers in whole millionths) and codec
  (columns of whole numbers as bytes). named_requests: requests by name, which are judged again.
- verification: checks if a match plays as recorded. comparison: the first differences of two matches.
  state_differences: the differences of two states. motion: poses between two states.
"""

from catch_arena.replay.fileformat import checked_names, checked_text
from catch_arena.replay.recording import Replay

__all__ = ["Replay", "checked_names", "checked_text"]
