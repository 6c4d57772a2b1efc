"""The supervisor, as it is on macOS: the families of processes cannot be listed."""

from catch_arena import descendants
from catch_arena.tournament.isolation import processes, supervisor


def main():
    descendants.LINUX = supervisor.LINUX = processes.LINUX = False
    supervisor.main()
