"""Writes where our runner's answers go."""

import os


class Agent:
    def reset(self, seed):
        pass

    def act(self, view):
        os.write(4, b"no JSON\n")
        return 0
