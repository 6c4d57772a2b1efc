"""A person plays in a real window: keys go in through the X server, and pictures come out."""

import time

import numpy as np

from catch_arena.render.hud import CARD, PANEL
from catch_arena.render.match_info import HUNTER_COLORS
from catch_arena.render.viewport import GROUND
from catch_arena.replay import Replay
from catch_arena.replay.comparison import verify

COMMAND = "from catch_arena.__main__ import main; main()"
HUMAN = """
import catch_arena
env = catch_arena.parallel_env("duel", render_mode="human")
env.reset(seed=1)
while env.agents:
    env.step({agent: 1 for agent in env.agents})
"""


def share(picture: np.ndarray, color: tuple[int, int, int]) -> float:
    """Return the share of a picture that has this colour."""
    return float((np.abs(picture.astype(int) - color).max(axis=2) < 10).mean()) if picture.size else 0.0


def still(desk) -> bool:
    """Nothing moves in the window."""
    before = desk.seen()
    time.sleep(0.4)
    return np.array_equal(before, desk.seen())


def test_a_person_drives_pauses_steps_saves_and_ends(desk, started, keep, tmp_path):
    words = [
        "play",
        "nearest",
        "--scenario",
        "duel",
        "--record",
        "mine.replay",
        "--set",
        "time_limit_s=60",
    ]
    process = started(COMMAND, *words)
    record = tmp_path / "mine.replay"

    def played() -> int:
        """Steps, by the replay that Ctrl-S saves: sleeping says nothing on a machine with other things to do."""
        desk.keys("key", "ctrl+s")
        time.sleep(0.1)
        return Replay.load(record).steps if record.stat().st_size else 0  # a reserved file is empty

    desk.wait(lambda: share(desk.seen(), PANEL) > 0.3)
    assert desk.window()[1][2:] == (1280, 720)
    desk.wait(lambda: still(desk))  # it waits, with the keys on show
    keep("1_keys", desk.picture())
    card = share(desk.seen()[:, :700], PANEL)

    desk.keys("keydown", "Up")
    desk.wait(lambda: share(desk.seen()[:, :700], PANEL) < 0.5 * card)  # the card is gone
    desk.wait(lambda: played() >= 8)
    desk.keys("keydown", "Left")
    turning = played()
    desk.wait(lambda: played() >= turning + 6)
    desk.keys("keyup", "Left")
    desk.keys("keyup", "Up")
    keep("2_driving", desk.picture())
    seen = desk.seen()[:, :720]
    assert share(seen, GROUND) > 0.4
    assert share(seen, HUNTER_COLORS[0]) > 0.00005  # one's turtle; the trail may have faded by now

    desk.keys("key", "space")
    desk.wait(lambda: still(desk))
    keep("3_paused", desk.picture())
    before = desk.seen()
    desk.keys("key", "period")
    desk.wait(lambda: not np.array_equal(before, desk.seen()))
    desk.wait(lambda: still(desk))
    saved = played()
    assert 14 <= saved < 600

    desk.keys("key", "p")
    desk.wait(lambda: not still(desk))
    desk.keys("key", "Escape")
    output = process.communicate(timeout=120)[0]
    assert process.returncode == 0, output
    assert "replay: mine.replay" in output
    mine = Replay.load(record)
    assert mine.names == ("you", "nearest")
    assert mine.steps >= saved
    assert list(verify(mine)) == []
    linear, angular = np.array(mine.commands)[:, 0].T
    assert linear[:8].tolist() == [1.0] * 8
    assert angular.max() == 1.0
    assert angular.min() == 0.0


def test_the_window_can_be_resized(desk, started, keep):
    started(COMMAND, "watch", "nearest", "patrol", "--scenario", "duel")
    desk.wait(lambda: share(desk.seen(), GROUND) > 0.2)
    window, _ = desk.window()
    desk.keys("windowsize", "--sync", window, "700", "800")
    desk.wait(lambda: desk.seen().shape[:2] == (800, 700) and share(desk.seen()[100:500], GROUND) > 0.3)
    desk.wait(lambda: share(desk.seen()[-60:], CARD) > 0.3)  # drawn for this size, to its edges
    keep("4_resized", desk.picture())
    desk.keys("key", "Escape")


def test_render_mode_human_shows_the_match_in_motion(desk, started, keep):
    process = started(HUMAN)
    desk.wait(lambda: share(desk.seen(), GROUND) > 0.4)
    assert desk.window()[1][2:] == (500, 500)
    desk.wait(lambda: not still(desk))
    keep("5_human", desk.picture())
    assert process.poll() is None
