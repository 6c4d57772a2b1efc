"""Counts its instances in its module, its class and a file."""

from pathlib import Path

made = []


class Agent:
    made = 0

    def __init__(self):
        made.append(self)
        Agent.made += 1
        Path("made").open("a").write("x")
        print("made", len(made), Agent.made, len(Path("made").read_text()))

    def reset(self, seed):
        pass

    def act(self, view):
        return 0
