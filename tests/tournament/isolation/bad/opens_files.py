"""Opens a thousand files in its fifth step."""

import os


class Agent:
    def reset(self, seed):
        self.step = 0

    def act(self, view):
        self.step += 1
        if self.step == 5:
            self.files = [os.open("/dev/null", os.O_RDONLY) for _ in range(1000)]
        return 0
