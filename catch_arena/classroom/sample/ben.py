# solved by ben


class Agent:
    def reset(self, seed):
        self.pick = 0

    def act(self, v):
        self.pick = 1 if v.targets else 0
        for turtle in v.targets:
            closer = [other for other in v.rivals if other.distance_to(turtle) < turtle.distance]
            if not closer:
                self.pick = turtle.rank
                break
        return self.pick
