"""`render --what-if` shows what would have won a contest as a ghost."""

from pathlib import Path

import pytest
from render.videos import decoded
from typer.testing import CliRunner

from catch_arena import explain, what_if
from catch_arena.cli import main
from catch_arena.errors import ConfigError
from catch_arena.player import player_page
from catch_arena.render import shapes
from catch_arena.render.ghost import ghost_shapes, ghost_track
from catch_arena.render.video import render_replay
from catch_arena.render.viewport import Viewport

WHITE = (255, 255, 255)
SMALL = {"size": (480, 320), "fps": 10}


@pytest.fixture(scope="module")
def match(play):
    return play(seed=3, reach_m=0.8, max_cycles=80, names=("ann", "bob", "cid", "dan"))


@pytest.fixture(scope="module")
def answer(match):
    """The first answer with an alternative."""
    answers = (what_if(match, contest) for contest in explain(match).contests)
    return next(answer for answer in answers if answer.alternative is not None)


def test_the_ghost_leaves_the_recorded_way_and_drives_the_alternative(match, answer):
    track, first = ghost_track(answer), min(answer.actions)
    recorded, alternative = list(match.worlds())[first], list(answer.alternative.worlds())
    for (time_ms, pose), world in ((track[0], recorded), (track[-1], alternative[-1])):
        hunter = world.hunters[answer.seat]
        assert pose == pytest.approx((hunter.x, hunter.y, hunter.theta))
        assert world.time_ms - 16 < time_ms <= world.time_ms
    times = [time_ms for time_ms, _ in track]
    assert times == sorted(set(times))


def test_the_ghost_appears_with_the_change_and_stays_at_the_end(answer):
    viewport, track = Viewport(400, 400, 11.0), ghost_track(answer)
    assert ghost_shapes(viewport, WHITE, track, track[0][0] - 1.0) == []
    begun, last = (ghost_shapes(viewport, WHITE, track, time_ms) for time_ms in (track[0][0], track[-1][0] + 900.0))
    for (way, turtle), (_, pose) in ((begun, track[0]), (last, track[-1])):
        assert isinstance(way, shapes.Path)
        assert isinstance(turtle, shapes.Turtle)
        assert way.points[-1] == (turtle.x, turtle.y) == viewport.to_pixels(*pose[:2])
        assert turtle.faded
    assert len(last[0].points) > len(begun[0].points)


def test_the_video_shows_the_part_around_the_contest(match, answer, tmp_path):
    """With the ghost and the words; without captions, the ghost alone."""
    frames = {}
    for captions in ("plain", "none"):
        report = render_replay(match, tmp_path / f"{captions}.gif", what_if=answer, captions=captions, **SMALL)
        begin_ms = max(0, answer.contest.judged_ms - 2000)
        assert report.seconds == (min(match.duration_ms, answer.contest.judged_ms + 1500) - begin_ms) / 1000.0
        frames[captions] = decoded(report.path)
    part = {"start_s": begin_ms / 1000.0, "end_s": begin_ms / 1000.0 + report.seconds}
    plain = decoded(render_replay(match, tmp_path / "plainly.gif", captions="none", **part, **SMALL).path)
    ghost, words = ((frames["none"][-1] != plain[-1]).any(), (frames["plain"][-1] != frames["none"][-1]).any())
    assert ghost
    assert words
    with pytest.raises(ConfigError, match="the start and the end must be left out with what_if"):
        render_replay(match, tmp_path / "x.gif", what_if=answer, start_s=1.0)


def test_the_command_writes_the_video_or_a_page_and_says_the_answer(match, answer, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    match.save("a.replay")
    at = f"{answer.contest.judged_ms / 1000.0:g}"
    words = ["render", "a.replay", "--what-if", at, "--size", "480x320", "--fps", "10"]
    said = CliRunner().invoke(main, words)
    assert said.exit_code == 0, said.output
    assert said.stdout.splitlines()[0] == answer.sentence
    assert (tmp_path / f"a-what-if-{at}s.mp4").is_file()
    page = CliRunner().invoke(main, [*words[:4], "-o", "a.html"])
    assert page.stdout.splitlines() == [answer.sentence, "page: a.html"]
    assert Path("a.html").read_text(encoding="utf-8") == player_page(match, answer)
    loser, winner = match.names[answer.seat], match.names[answer.contest.claims[0].seat]
    said = CliRunner().invoke(main, [*words, "--hunter", loser, "-o", "b.gif"])
    assert said.stdout.splitlines()[0] == answer.sentence
    for refused, error in (
        ([*words, "--from", "1"], "--from and --to must be left out with --what-if"),
        ([*words, "--hunter", winner, "-o", "c.gif"], f"the time of a contest that was lost by {winner}"),
        (["render", "a.replay", "--hunter", loser], "--hunter needs --what-if"),
        ([*words, "-o", "b.html"], "b.html: options of a video must be left out for a page"),
        (["render", "a.replay", "-o", "b.html", "--to", "3"], "options of a video must be left out for a page"),
    ):
        result = CliRunner().invoke(main, refused)
        assert result.exit_code == 2
        assert error in result.stderr
