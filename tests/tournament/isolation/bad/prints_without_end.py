"""Prints ten megabytes in each of its first steps, and plays on."""

import sys


class Agent:
    def reset(self, seed):
        self.step = 0
        print("the first line")

    def act(self, view):
        self.step += 1
        if self.step <= 3:
            for _ in range(10):
                sys.stdout.write("x" * 1_000_000)
            print(f"the end of step {self.step}", flush=True)
        return 0
