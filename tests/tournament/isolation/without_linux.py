"""The keeper, as it is on macOS: the families of processes cannot be listed."""

from catch_arena import descendants
from catch_arena.tournament.isolation import keeper, processes


def main():
    descendants.LINUX = keeper.LINUX = processes.LINUX = False
    keeper.main()
