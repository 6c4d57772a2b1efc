"""Closes its answers, and lives on."""

import os
import time


class Agent:
    def reset(self, seed):
        pass

    def act(self, view):
        os.close(4)
        time.sleep(3600)
