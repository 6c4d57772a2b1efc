"""Leaves in the fifth step, past every exception handler."""

import os


class Agent:
    def reset(self, seed):
        self.step = 0

    def act(self, view):
        self.step += 1
        if self.step == 5:
            os._exit(3)
        return 0
