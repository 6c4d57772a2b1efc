"""Matches that are kept: recorded, saved, loaded, played again, checked and compared (docs/replays.md)."""

from catch_arena.replay.fileformat import checked_text
from catch_arena.replay.files import regular_file, room, unwritable, whole_file, write_whole
from catch_arena.replay.recording import Replay

__all__ = ["Replay", "checked_text", "regular_file", "room", "unwritable", "whole_file", "write_whole"]
