"""The clock on the wall may jump while a match is played: nothing reads it."""

import random
import re
import time
from pathlib import Path

import catch_arena
from catch_arena import scenario
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.execution.runner import run
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.starting import inspector, sandbox_for
from catch_arena.tournament.plans.schedule import round_robin

PACKAGE = Path(catch_arena.__file__).parent
WALL = re.compile(
    r"\btime\.(time|time_ns|localtime|gmtime|ctime|asctime|strftime)\b|\b(date|datetime)\.(now|utcnow|today)\b"
)


def test_no_module_asks_for_the_time_of_day():
    assert [path for path in PACKAGE.rglob("*.py") if WALL.search(path.read_text(encoding="utf-8"))] == []


def test_a_match_during_which_the_clock_jumps_by_years_comes_out_as_any_other(tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text(
        "class Agent:\n    def reset(self, seed): pass\n    def act(self, view): return 1 if view.targets else 0\n"
    )
    limits = AgentLimits(init_s=60, step_ms=60_000)
    with sandbox_for(limits) as sandbox:
        entrants = enter([str(tmp_path / "mine.py"), "nearest"], inspector(sandbox))
    config, plan = scenario("duel", time_limit_s=6), round_robin(2, 2, 1, seed=0)
    before = run(config, entrants, plan, limits=limits)
    draw = random.Random(1)
    monkeypatch.setattr(time, "time", lambda: draw.uniform(0, 4e9))
    monkeypatch.setattr(time, "time_ns", lambda: draw.randrange(4 * 10**18))
    after = run(config, entrants, plan, limits=limits)
    assert after == before
    for one in after:
        assert all(0 <= seat.longest_s <= seat.total_s < 60 for seat in one.result.thinking)
