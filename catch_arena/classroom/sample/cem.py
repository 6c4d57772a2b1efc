class Agent:
    """Always goes for the second target, also if there is only one."""

    def reset(self, seed):
        pass

    def act(self, view):
        print("targets:", len(view.targets))
        return view.targets[1].rank
