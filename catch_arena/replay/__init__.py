"""Matches that are kept: recorded, saved, loaded, played again, checked and compared (docs/replays.md)."""

from catch_arena.replay.fileformat import checked_names, checked_text
from catch_arena.replay.recording import Replay

__all__ = ["Replay", "checked_names", "checked_text"]
