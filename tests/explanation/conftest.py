"""Matches that the tests of this folder record."""

from recorded_matches import fleeing, mixed, play

__all__ = ["fleeing", "mixed", "play"]
