"""Takes eight gigabytes in its fifth step, as memory that could be shared."""

import mmap


class Agent:
    def reset(self, seed):
        self.step = 0

    def act(self, view):
        self.step += 1
        if self.step == 5:
            self.hoard = mmap.mmap(-1, 8 << 30)
        return 0
