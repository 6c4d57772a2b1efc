"""The supervisor with its second way to end processes, by groups: for systems that do not list descendants."""

from catch_arena import descendants
from catch_arena.tournament.isolation import processes, servers, supervisor


def main():
    descendants.LINUX = servers.LINUX = supervisor.LINUX = processes.LINUX = False
    supervisor.main()
