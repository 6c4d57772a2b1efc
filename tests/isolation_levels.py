"""The levels of isolation that this machine can hold: tests of isolation run at each of them."""

from catch_arena.tournament.isolation.namespaces import namespaces_missing

MISSING = namespaces_missing()
LEVELS = ["processes"] if MISSING else ["namespaces", "processes"]
