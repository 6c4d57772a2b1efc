"""A mosaic shows up to 64 matches in one video."""

import numpy as np
import pytest
from render.videos import decoded

from catch_arena.errors import ConfigError
from catch_arena.render import mosaic
from catch_arena.render.mosaic import fit_grid, render_mosaic
from catch_arena.render.viewport import GROUND


@pytest.fixture(scope="module")
def matches(play):
    """Matches of one, two and three seconds."""
    return {f"m{s}": play("duel", seed=s, time_limit_s=float(s)) for s in (1, 2, 3)}


@pytest.fixture(autouse=True)
def small(monkeypatch):
    """Videos of fewer pixels and frames than usual."""
    for size in ("LARGEST", "LARGEST_SMALL"):
        monkeypatch.setattr(mosaic, size, (640, 640))
    monkeypatch.setattr(mosaic, "MOST_FPS", 10)


@pytest.mark.parametrize("ending", [".mp4", ".gif"])
def test_all_run_at_once_and_the_video_lasts_as_long_as_the_longest(matches, tmp_path, ending):
    seen = []
    report = render_mosaic(matches, tmp_path / f"grid{ending}", progress=lambda *done: seen.append(done))
    frames = decoded(report.path)
    assert report.frames == len(frames) == 51  # three seconds, the last picture, and two seconds to look at it
    assert seen[:51] == [(k, 51) for k in range(1, 52)]
    grid = fit_grid(3, (640, 640), 0.165)
    assert frames[0].shape == (*report.size[::-1], 3)
    cells = grid.cells(3)
    for cell, ends in zip(cells, (11, 21, 31), strict=True):
        shown = [
            frame[cell.top + 40 : cell.top + 120, cell.left + 20 : cell.left + 100].astype(int) for frame in frames
        ]
        ground = [np.median(part.reshape(-1, 3), axis=0) for part in shown]
        assert np.abs(ground[ends - 2] - GROUND).max() < 12
        assert ground[ends + 1][2] < 0.6 * GROUND[2]  # it has ended, and is darker
        assert np.abs(shown[ends + 2] - shown[50]).mean() < 6  # and stands still


def test_a_match_that_does_not_play_as_recorded_stops_and_the_others_go_on(matches, play, tmp_path):
    broken = play("duel", seed=9, time_limit_s=3.0)
    broken.digests[5] = b"12345678"
    report = render_mosaic({"good": matches["m3"], "broken": broken}, tmp_path / "grid.mp4")
    assert len(decoded(report.path)) == 51


@pytest.mark.parametrize(("ending", "largest"), [(".mp4", 1280), (".webp", 720)])
@pytest.mark.parametrize("count", [1, 64])
def test_from_one_match_to_sixty_four(play, tmp_path, monkeypatch, count, ending, largest):
    monkeypatch.undo()
    monkeypatch.setattr(mosaic, "MOST_FPS", 2)
    short = play("duel", time_limit_s=0.2)
    report = render_mosaic({str(k): short for k in range(count)}, tmp_path / f"grid{ending}")
    assert 0.8 * largest < max(report.size) <= largest
    assert min(report.size) >= 320
    assert decoded(report.path)[0].shape[:2] == report.size[::-1]


def test_what_cannot_be_is_said(matches, tmp_path):
    match = matches["m1"]
    with pytest.raises(ConfigError, match="1 to 64 matches, got 65"):
        render_mosaic({str(k): match for k in range(65)}, tmp_path / "grid.mp4")
    with pytest.raises(ConfigError, match="speed"):
        render_mosaic({"m": match}, tmp_path / "grid.mp4", speed=0.0)
    assert list(tmp_path.iterdir()) == []
