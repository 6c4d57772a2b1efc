"""Writes zeros without end where our runner's answers go."""

import os


class Agent:
    def reset(self, seed):
        pass

    def act(self, view):
        while True:
            os.write(4, bytes(4096))
