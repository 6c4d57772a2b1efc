"""A whole video begins with a title and ends with the podium of the match's last instant; a part has neither."""

import pytest
from render.pictured import SIZES, assert_inside, assert_texts_apart, kinds
from render.videos import decoded, drawn, psnr

from catch_arena.config import ArenaConfig
from catch_arena.render import cards, hud
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import Label
from catch_arena.render.text import text_width
from catch_arena.render.video import render_replay

SMALL = {"size": (480, 320), "fps": 10}


def test_a_whole_match_has_its_title_every_frame_its_last_instant_and_its_podium(match, tmp_path):
    report = render_replay(match, tmp_path / "whole.mp4", event="winter cup, 2026-11-28", **SMALL)
    seen, meant = decoded(report.path), drawn(match, **SMALL)
    assert report.frames == len(seen) == 20 + 30 + 1 + 40
    assert min(psnr(a, b) for a, b in zip(seen[20:50], meant, strict=True)) > 24.0
    bright = [frame[:, :250].mean() for frame in seen]  # the arena
    assert max(bright[5], bright[60]) < 0.5 * bright[30]
    assert psnr(seen[50], meant[-1]) > 20.0
    part = render_replay(match, tmp_path / "part.mp4", start_s=0.0, **SMALL)
    assert part.frames == 30


@pytest.mark.parametrize(
    ("names", "scores", "text"),
    [
        ("ab", (3, 1), "a wins by 2"),
        (("you", "b"), (3, 1), "you win by 2"),
        ("ab", (2, 2), "a and b share the first place"),
        ("abc", (2, 2, 2), "3 share the first place"),
        ("a", (1,), "a: 1 catch"),
        ("ab", (0, 0), "a and b share the first place"),
    ],
)
def test_the_podium_says_who_won_and_by_how_much(names, scores, text):
    info = MatchInfo.of(ArenaConfig(hunters=len(names)), names)
    shapes = cards.podium_shapes((720, 720), info, scores, ())
    texts = [label.text for label in kinds(shapes, Label)]
    assert texts[0] == text
    assert texts.count(str(max(scores))) >= 1


@pytest.mark.parametrize("hunters", [1, 2, 4, 16, 64])
@pytest.mark.parametrize("size", SIZES)
def test_cards_stay_inside_and_no_text_covers_another(size, hunters):
    names = [f"contested_by_arrival_time_v{seat}" for seat in range(hunters)]
    info = MatchInfo.of(ArenaConfig(hunters=hunters, prey=2), [*names, "flee", ""], "m" * 200, 60_000, event="e" * 200)
    prey = [hud.AgentScore(hunters, 3, hunted=True), hud.AgentScore(hunters + 1, 1, hunted=True)]
    for shapes in (cards.title_shapes(size, info), cards.podium_shapes(size, info, range(hunters), prey)):
        assert_inside(kinds(shapes, Label), hud.Rect(0, 0, *size))
        assert_texts_apart(shapes)


@pytest.mark.parametrize("area", [(794, 720), (397, 360), (1080, 1080)])
@pytest.mark.parametrize(
    "settings", [{}, {"prey": 2, "spawn_frequency_hz": 0.0}, {"teams": ((0, 1), (2, 3))}, {"policy": "capstone"}]
)
def test_the_title_tells_the_goal_whole(area, settings):
    """In the arena of a video, of a GIF and of a phone's picture."""
    info = MatchInfo.of(ArenaConfig(**settings), ["a"] * (4 + settings.get("prey", 0)), duration_ms=60_000)
    goal = cards.goal(info)
    labels = {label.text: label for label in kinds(cards.title_shapes(area, info), Label)}
    for text in goal:
        label = labels[text]
        assert text_width(text, label.size, label.weight) <= label.max_width


@pytest.mark.parametrize(
    ("shape", "size", "even"),
    [("portrait", None, (1080, 1920)), ("square", None, (1080, 1080)), ("portrait", (320, 640), (320, 640))],
)
def test_a_shape_gives_the_size(play, tmp_path, shape, size, even):
    report = render_replay(play("duel", max_cycles=2), tmp_path / "v.mp4", shape=shape, size=size, fps=1, start_s=0.0)
    assert report.size == even


@pytest.mark.parametrize("size", [size for size in SIZES if size[0] >= 1.25 * size[1]])
def test_in_landscape_the_arena_has_sixty_percent(size):
    arena = hud.arrange(size, "broadcast", 4).arena
    assert arena.width * arena.height >= 0.6 * size[0] * size[1]
