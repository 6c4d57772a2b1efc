"""Matches that the tests of this folder record."""

from recorded_matches import fleeing, hunted, hunted_once, mixed, named, play

__all__ = ["fleeing", "hunted", "hunted_once", "mixed", "named", "play"]
