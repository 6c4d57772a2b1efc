"""Kills its parent, and plays on if that changes nothing."""

import os
import signal
import time


class Agent:
    def reset(self, seed):
        self.tried = False

    def act(self, view):
        if not self.tried:
            os.kill(os.getppid(), signal.SIGKILL)
            time.sleep(1)
            self.tried = True
        return 0
