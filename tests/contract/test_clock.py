"""Nothing reads the clock on the wall, which may jump while a match is played."""

import random
import re
import time
from pathlib import Path

import catch_arena
from catch_arena import scenario
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import sandbox_for
from catch_arena.tournament.match_loop import play_entrants
from catch_arena.tournament.players import enter

PACKAGE = Path(catch_arena.__file__).parent
WALL = re.compile(
    r"\btime\.(time|time_ns|localtime|gmtime|ctime|asctime|strftime)\b|\b(date|datetime)\.(now|utcnow|today)\b"
)


def test_no_module_asks_for_the_time_of_day_except_the_command_that_dates_the_runs_of_a_league():
    found = [path for path in PACKAGE.rglob("*.py") if WALL.search(path.read_text(encoding="utf-8"))]
    assert found == [PACKAGE / "cli" / "league.py"]


def test_a_match_during_which_the_clock_jumps_by_years_comes_out_as_any_other(tmp_path, monkeypatch):
    """Played and measured by this process: one agent in it, and one isolated."""
    (tmp_path / "mine.py").write_text(
        "class Agent:\n    def reset(self, seed): pass\n    def act(self, view): return 1 if view.targets else 0\n"
    )
    quotas = Quotas(init_s=60, step_ms=60_000)
    with sandbox_for(quotas) as sandbox:
        entrants = enter([str(tmp_path / "mine.py"), "nearest"], sandbox)
        config = scenario("duel", time_limit_s=6)
        before = play_entrants(config, 5, entrants, sandbox)
        draw = random.Random(1)
        monkeypatch.setattr(time, "time", lambda: draw.uniform(0, 4e9))
        monkeypatch.setattr(time, "time_ns", lambda: draw.randrange(4 * 10**18))
        after = play_entrants(config, 5, entrants, sandbox)
    assert (after.digest, after.scores, after.forfeits) == (before.digest, before.scores, (None, None))
    assert all(0 <= seat.longest_s <= seat.total_s < 60 for seat in after.thinking)
