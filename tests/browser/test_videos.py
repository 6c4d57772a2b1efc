"""What people see who open a video in a browser."""

import numpy as np
import pytest

import catch_arena
from catch_arena.render import hud, match_info, viewport
from catch_arena.render.encoders import FORMATS, video_file
from catch_arena.render.video import render_replay
from catch_arena.replay import Replay

MOVIES = [".mp4", ".webm"]
PICTURES = [".gif", ".webp"]

_PIXELS = """
source => {
    const canvas = document.createElement("canvas");
    canvas.width = source.videoWidth || source.naturalWidth;
    canvas.height = source.videoHeight || source.naturalHeight;
    const context = canvas.getContext("2d", {colorSpace: "srgb"});
    context.drawImage(source, 0, 0);
    return [canvas.width, canvas.height, Array.from(context.getImageData(0, 0, canvas.width, canvas.height).data)];
}
"""


@pytest.fixture(scope="module")
def match() -> Replay:
    env = catch_arena.parallel_env("standard", time_limit_s=2.0)
    env.record()
    _, infos = env.reset(seed=3)
    while env.agents:
        _, _, _, _, infos = env.step({agent: int(infos[agent]["action_mask"][1]) for agent in env.agents})
    return env.replay()


def shown(page, selector: str) -> np.ndarray:
    """The picture that an element shows now: (height, width, 3)."""
    width, height, numbers = page.eval_on_selector(selector, _PIXELS)
    return np.array(numbers, dtype=np.uint8).reshape(height, width, 4)[..., :3]


def open_movie(page, address: str) -> None:
    page.goto(f"{address}/index.html")
    page.eval_on_selector("video", "video => video.play()")
    page.wait_for_function("document.querySelector('video').currentTime > 0.4")


@pytest.mark.parametrize("ending", MOVIES)
def test_a_match_plays(page, serve, tmp_path, match, ending):
    report = render_replay(match, tmp_path / f"match{ending}", size=(640, 360))
    (tmp_path / "index.html").write_text(f'<video muted src="match{ending}"></video>')
    open_movie(page, serve(tmp_path))
    before = page.eval_on_selector("video", "video => video.currentTime")
    page.wait_for_function(f"document.querySelector('video').currentTime > {before + 0.3}")
    assert page.eval_on_selector("video", "video => video.duration") == pytest.approx(report.seconds, abs=0.05)
    frame = shown(page, "video")
    assert frame.shape == (360, 640, 3)
    assert frame.astype(float).mean() > 40  # not black
    assert np.abs(frame[40:320, 20:340].astype(int) - viewport.GROUND).sum(axis=2).mean() < 60  # but the arena
    page.wait_for_function("document.querySelector('video').ended")
    assert page.eval_on_selector("video", "video => video.error") is None
    quality = page.eval_on_selector("video", "video => video.getVideoPlaybackQuality().corruptedVideoFrames || 0")
    assert quality == 0


@pytest.mark.parametrize("ending", PICTURES)
def test_a_match_moves_as_a_picture(page, serve, tmp_path, match, ending):
    report = render_replay(match, tmp_path / f"match{ending}", fps=20)
    (tmp_path / "index.html").write_text(f'<img src="match{ending}">')
    page.goto(f"{serve(tmp_path)}/index.html")
    page.wait_for_function("document.querySelector('img').complete")
    first = shown(page, "img")
    assert first.shape == (360, 640, 3)
    assert np.abs(first[40:320, 20:340].astype(int) - viewport.GROUND).sum(axis=2).mean() < 60
    frames = page.evaluate(
        """async ([name, type]) => {
            const data = await (await fetch(name)).arrayBuffer();
            const decoder = new ImageDecoder({data, type});
            await decoder.completed;
            await decoder.tracks.ready;
            const track = decoder.tracks.selectedTrack;
            return [track.frameCount, track.repetitionCount === Infinity];
        }""",
        [f"match{ending}", f"image/{ending[1:]}"],
    )
    assert frames == [report.frames, True]


@pytest.mark.parametrize("ending", FORMATS)
def test_colours_are_right_within_three_levels(page, serve, tmp_path, ending):
    """A patch of every colour that matters, written by the encoder and read from the browser's screen."""
    colors = [
        *match_info.HUNTER_COLORS,
        viewport.GROUND,
        viewport.TARGET,
        hud.PANEL,
        (255, 255, 255),
        (0, 0, 0),
        (128, 128, 128),
    ]
    side = 48
    picture = np.zeros((side * 2, side * 7, 4), dtype=np.uint8)
    for place, color in enumerate(colors):
        row, column = divmod(place, 7)
        picture[side * row : side * (row + 1), side * column : side * (column + 1), :3] = color
    with video_file(tmp_path / f"patches{ending}", (side * 7, side * 2), 25) as video:
        for _ in range(25):
            video.write(picture)
    tag = "video muted" if ending in MOVIES else "img"
    (tmp_path / "index.html").write_text(f'<{tag} src="patches{ending}"></{tag.split(maxsplit=1)[0]}>')
    address = serve(tmp_path)
    if ending in MOVIES:
        open_movie(page, address)
    else:
        page.goto(f"{address}/index.html")
        page.wait_for_function("document.querySelector('img').complete")
    seen = shown(page, tag.split(maxsplit=1)[0]).astype(float)
    for place, color in enumerate(colors):
        row, column = divmod(place, 7)
        patch = seen[side * row + 12 : side * (row + 1) - 12, side * column + 12 : side * (column + 1) - 12]
        assert np.abs(patch.mean(axis=(0, 1)) - color).max() <= 3.0, (color, patch.mean(axis=(0, 1)))
