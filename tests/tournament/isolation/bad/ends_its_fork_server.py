"""Kills its parent."""

import os
import signal
import time


class Agent:
    def reset(self, seed):
        pass

    def act(self, view):
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(3600)
