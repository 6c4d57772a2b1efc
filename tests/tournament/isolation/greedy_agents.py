"""An agent that takes too much in its first step, and what is said of it."""

from catch_arena import scenario
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.isolation.inspecting import inspector
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.isolation.starting import start_players
from catch_arena.tournament.match_loop import play

SHORT = scenario("duel", time_limit_s=1)
FREE = {"init_s": 60, "step_ms": 60_000}
_AGENT = """
import mmap, os, socket, threading, time
from contextlib import suppress

class Agent:
    def reset(self, seed):
        self.tried = False

    def act(self, view):
        if not self.tried:
            self.tried = True
            self.take()
            time.sleep(30)
        return 0

    def take(self):
"""


def reason_of(tmp_path, what, **limits):
    """Why an agent fails that does that, beside one that does nothing."""
    path = tmp_path / "takes.py"
    path.write_text(_AGENT + what)
    with Sandbox(AgentLimits(**FREE, **limits)) as sandbox:
        entrants = enter([str(path), "idle"], inspector(sandbox))
        for _ in range(2):  # and the next match is like the first
            with start_players(entrants, sandbox) as players:
                result = play(SHORT, 1, players, ["takes", "idle"])
            assert result.forfeits == ("FORFEIT_CRASH", None)
            assert result.ranks == (2, 1)
    return result.details[0].reason
