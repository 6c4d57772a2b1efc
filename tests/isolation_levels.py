"""Levels of isolation that tests can use on this machine."""

from catch_arena.tournament.isolation.namespaces import namespaces_fault

_MISSING = namespaces_fault()
LEVELS = ["processes"] if _MISSING else ["namespaces", "processes"]
NAMESPACES = LEVELS[:-1]
"""For tests of that level alone."""

NOT_TESTED = [f"isolation in namespaces was not tested: {_MISSING}"] if _MISSING else []
