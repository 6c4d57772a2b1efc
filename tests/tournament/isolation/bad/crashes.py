"""Plays four steps, then raises."""


class Agent:
    def reset(self, seed):
        self.step = 0

    def act(self, view):
        self.step += 1
        return 1 // (5 - self.step) * 0
