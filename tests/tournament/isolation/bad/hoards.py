"""Takes eight gigabytes in its fifth step."""


class Agent:
    def reset(self, seed):
        self.step = 0

    def act(self, view):
        self.step += 1
        if self.step == 5:
            self.hoard = bytearray(8 << 30)
        return 0
