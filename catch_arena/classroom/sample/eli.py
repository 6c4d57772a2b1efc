class Agent:
    """Drives itself, and asks for the nearest target from far away too."""

    control = "full"

    def reset(self, seed):
        pass

    def act(self, view):
        if not view.targets:
            return {"cmd_vel": (0.0, 0.0), "catch": 0}
        nearest = view.targets[0]
        turn = max(-1.0, min(1.0, 2.0 * nearest.bearing))
        return {"cmd_vel": (1.0 if abs(nearest.bearing) < 0.5 else 0.1, turn), "catch": 1}
