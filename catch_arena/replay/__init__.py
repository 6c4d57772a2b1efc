"""Matches that are kept: recorded, saved, loaded, played again, checked and compared (docs/replays.md)."""

from catch_arena.replay.fileformat import checked_text
from catch_arena.replay.files import prepare_folder, regular_file, room, unwritable, whole_file, write_whole
from catch_arena.replay.recording import Replay

__all__ = [
    "Replay",
    "checked_text",
    "prepare_folder",
    "regular_file",
    "room",
    "unwritable",
    "whole_file",
    "write_whole",
]
