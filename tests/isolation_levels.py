"""Levels of isolation, and runtimes for agents, that tests can use on this machine."""

import shutil

from catch_arena.tournament.isolation.namespaces import namespaces_missing

_MISSING = namespaces_missing()
LEVELS = ["processes"] if _MISSING else ["namespaces", "processes"]
NAMESPACES = LEVELS[:-1]
"""For tests of that level alone."""

RUNTIMES = [name for name, program in (("node", "node"), ("java", "javac")) if shutil.which(program)]

NOT_TESTED = [f"isolation in namespaces was not tested: {_MISSING}"] if _MISSING else []
if absent := [name for name in ("node", "java") if name not in RUNTIMES]:
    NOT_TESTED.append(f"agents were not tested in {', '.join(absent)}: not installed here")
