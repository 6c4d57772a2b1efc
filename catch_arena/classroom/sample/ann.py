from catch_arena.policy import View


class Agent:
    """Takes the nearest target that no rival is nearer to."""

    def reset(self, seed: int) -> None:
        self.choice = 0

    def act(self, view: View) -> int:
        self.choice = 1 if view.targets else 0
        for target in view.targets:
            nearer = [rival for rival in view.rivals if rival.distance_to(target) < target.distance]
            if not nearer:
                self.choice = target.rank
                break
        return self.choice
