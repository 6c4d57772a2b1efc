"""Videos have the documented formats, and decode to the frames that were drawn."""

import sys
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from render.videos import ENDINGS, SMALL, decoded, drawn, psnr

from catch_arena.errors import ConfigError
from catch_arena.render.timing import Clip
from catch_arena.render.video import clip_of, render_replay


def boxes(path: Path) -> list[str]:
    """The names of an MP4 file's boxes, in order."""
    content, names, at = path.read_bytes(), [], 0
    while at < len(content):
        size = int.from_bytes(content[at : at + 4], "big")
        names.append(content[at + 4 : at + 8].decode())
        assert size >= 8
        at += size
    return names


@pytest.mark.parametrize(
    ("ending", "layout"), [*((ending, "broadcast") for ending in ENDINGS), (".mp4", "arena"), (".gif", "arena")]
)
def test_the_file_shows_the_frames_that_were_drawn_and_all_of_them(video, frames, ending, layout):
    report = video(ending, layout)
    seen, meant = decoded(report.path), frames(layout)
    assert report.frames == len(seen) == len(meant) == 90
    assert report.seconds == pytest.approx(3.0)
    # brightness survives; colours are stored at half the size, which costs most at their edges
    likeness = [
        psnr(cv2.cvtColor(a, cv2.COLOR_RGB2GRAY), cv2.cvtColor(b, cv2.COLOR_RGB2GRAY))
        for a, b in zip(seen, meant, strict=True)
    ]
    assert min(likeness) > 32.0
    assert min(psnr(a, b) for a, b in zip(seen, meant, strict=True)) > 24.0
    # and a frame is nearer to its own picture than to the one a quarter of a second on
    assert all(psnr(seen[k], meant[k]) > psnr(seen[k], meant[k + 8]) for k in range(20, 80, 10))


def test_browsers_can_play_it_while_it_loads(video):
    path = video(".mp4", "broadcast").path
    order = boxes(path)
    assert order[0] == "ftyp"
    assert order.index("moov") < order.index("mdat")
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        context = stream.codec_context
        assert (context.name, context.pix_fmt) == ("h264", "yuv420p")
        assert (context.colorspace, context.color_range) == (6, 1)
        assert (context.color_primaries, context.color_trc) == (1, 1)
        assert stream.average_rate == 30
        assert (stream.start_time, stream.duration * stream.time_base) == (0, 3)


@pytest.mark.parametrize("ending", [".gif", ".webp"])
def test_pictures_that_move_do_so_for_ever_and_for_as_long_as_the_match(video, ending):
    ok, animation = cv2.imreadanimation(str(video(ending, "broadcast").path))
    assert ok
    assert animation.loop_count == 0
    assert sum(animation.durations) == pytest.approx(3000, abs=35)


def test_a_webm_file_is_vp9_that_browsers_play(video):
    with av.open(str(video(".webm", "broadcast").path)) as container:
        context = container.streams.video[0].codec_context
        assert (container.format.name, context.name, context.pix_fmt) == ("matroska,webm", "vp9", "yuv420p")
        assert (context.colorspace, context.color_range) == (6, 1)


def test_a_part_is_rendered_as_it_is_in_the_whole(match, frames, tmp_path):
    """The trails, the score and the timeline of what came before are there."""
    whole = frames("broadcast")
    part = drawn(match, start_s=1.2, end_s=2.4, **SMALL)
    assert len(part) == 36
    for k in (0, 10, 35):
        assert psnr(part[k], whole[36 + k]) > 38.0
    report = render_replay(match, tmp_path / "part.mp4", start_s=1.2, end_s=2.4, **SMALL)
    assert (report.frames, report.seconds) == (36, pytest.approx(1.2))
    assert min(psnr(a, b) for a, b in zip(decoded(report.path), part, strict=True)) > 24.0


def test_slow_motion_shows_more_instants_and_a_time_lapse_fewer(match, frames):
    normal = frames("broadcast")
    slow = drawn(match, speed=0.25, end_s=1.0, **SMALL)
    fast = drawn(match, speed=3.0, **SMALL)
    assert (len(normal), len(slow), len(fast)) == (90, 120, 30)
    assert psnr(slow[80], normal[20]) > 30.0
    assert psnr(fast[20], normal[60]) > 30.0
    assert not np.array_equal(slow[81], slow[80])  # between two frames of the normal pace there is motion


@pytest.mark.parametrize(
    ("size", "even"), [((321, 321), (322, 322)), ((400, 335), (400, 336)), ((320, 320), (320, 320))]
)
def test_odd_sizes_become_the_next_even_ones(play, tmp_path, size, even):
    report = render_replay(play("duel", max_cycles=2), tmp_path / "odd.mp4", size=size, fps=10, start_s=0.0)
    assert report.size == even
    assert [frame.shape for frame in decoded(report.path)] == [(even[1], even[0], 3)] * 2


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_match_without_steps_is_one_frame(tmp_path, play, ending):
    replay = play("duel", max_cycles=1)
    replay.choices.clear()
    replay.commands.clear()
    del replay.digests[1:]
    assert render_replay(replay, tmp_path / f"none{ending}", start_s=0.0, **SMALL).frames == 1


def test_an_end_after_the_end_is_the_end(match):
    for end_s in (4.0, float("inf")):
        assert clip_of(match, 60, 1.0, end_s, 1.0) == Clip(1000, 3000, 60)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"size": (100, 100)}, r"size must be two whole numbers from 320 x 320 to 3840 x 2160, got \(100, 100\)"),
        ({"fps": 0}, "fps must be a whole number from 1 to 240 for MP4, got 0"),
        ({"fps": 59.94}, "fps must be a whole number from 1 to 240 for MP4, got 59.94"),
        ({"speed": 0.0}, "speed must be from 0.01 to 100, got 0.0"),
        ({"speed": float("nan")}, "speed must be from 0.01 to 100, got nan"),
        ({"start_s": 3.5}, r"the start must be from 0 to 3 s, the match's length, got 3.5"),
        ({"start_s": -1.0}, r"the start must be from 0 to 3 s, the match's length, got -1.0"),
        ({"start_s": 2.0, "end_s": 1.0}, r"the end must be after the start, 2 s, got 1.0"),
        ({"end_s": float("nan")}, r"the end must be after the start, 0 s, got nan"),
        ({"layout": "brodcast"}, "layout must be one of broadcast, arena, got 'brodcast'"),
        ({"shape": "round"}, "shape must be one of landscape, portrait, square, got 'round'"),
        ({"shape": "portrait", "size": (1280, 720)}, "size must be portrait, got 1280x720, which is landscape"),
        ({"captions": "loud"}, "captions must be one of plain, clauses, none, got 'loud'"),
    ],
)
def test_settings_that_cannot_be(match, tmp_path, settings, message):
    with pytest.raises(ConfigError, match=message):
        render_replay(match, tmp_path / "match.mp4", **settings)
    assert list(tmp_path.iterdir()) == []


def test_a_gif_is_not_asked_for_more_than_browsers_show(match, tmp_path):
    with pytest.raises(ConfigError, match="fps must be a whole number from 1 to 50 for GIF, got 60"):
        render_replay(match, tmp_path / "match.gif", fps=60)


@pytest.mark.parametrize("name", ["match.avi", "match", "match.mp4.zip"])
def test_another_kind_of_file_is_not_promised(match, tmp_path, name):
    with pytest.raises(ConfigError, match=r"path must end in \.mp4, \.webm, \.gif or \.webp, got"):
        render_replay(match, tmp_path / name)


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("lacking", ["PyAV", "its encoder"])
def test_without_the_encoder_there_is_no_file_and_one_line_says_what_to_install(
    match, tmp_path, monkeypatch, ending, lacking
):
    if lacking == "PyAV":
        monkeypatch.setitem(sys.modules, "av", None)
    else:
        monkeypatch.setattr(av, "codecs_available", {"mpeg4"})
    with pytest.raises(ConfigError, match=r"PyAV.*pip install '\.\[video\]'") as refused:
        render_replay(match, tmp_path / f"match{ending}", **SMALL)
    assert "\n" not in str(refused.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("settings", "view_of", "error"),
    [
        ({}, 0, "view_of needs a match that limits or blurs its hunters' views"),
        ({"view_radius_m": 2.0}, 4, "hunter must be a seat from 0 to 3, got 4"),
        ({"view_radius_m": 2.0}, "patrl", "unknown hunter 'patrl': did you mean patrol?"),
    ],
)
def test_a_view_that_cannot_be_shown_is_refused_and_writes_nothing(play, tmp_path, settings, view_of, error):
    names = ("contested", "nearest", "patrol", "first")
    match = play(max_cycles=2, names=names, **settings)
    with pytest.raises(ConfigError) as refused:
        render_replay(match, tmp_path / "x.gif", view_of=view_of, **SMALL)
    assert error in str(refused.value)
    assert list(tmp_path.iterdir()) == []
