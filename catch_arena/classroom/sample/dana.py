class Agent:
    """Waits in its place until something changes, and forgets to move itself."""

    def reset(self, seed):
        self.plan = []

    def act(self, view):
        while not self.plan:
            self.think(view)
        return self.plan.pop()

    def think(self, view):
        if view.score > 0:
            self.plan.append(1)
