"""Replays: matches that are recorded, saved, loaded, played again, checked and compared (docs/reference/replays.md).

- recording: `Replay`, a recorded match, and `Recorder` of the episodes of an arena.
- fileformat: the file of a replay, with codec (columns of whole numbers as bytes).
  named_requests: requests by name, which are judged again.
- comparison: checks if a match plays as recorded, and the first differences of two matches.
  motion: poses between two states.
"""

from catch_arena.replay.recording import Recorder as Recorder
from catch_arena.replay.recording import Replay as Replay
