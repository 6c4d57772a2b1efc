"""Writes a file of 100 MiB in its fifth step."""

from pathlib import Path


class Agent:
    def reset(self, seed):
        self.step = 0

    def act(self, view):
        self.step += 1
        if self.step == 5:
            Path("much").write_bytes(bytes(100 << 20))
        return 0
