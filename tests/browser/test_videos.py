"""Videos and animated pictures play in a real browser."""

import numpy as np
import pytest
from render.matches import played

from catch_arena.render import viewport
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
    return played(time_limit_s=2.0)


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
    report = render_replay(match, tmp_path / f"match{ending}", size=(640, 360), start_s=0.0)  # without a title
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
    report = render_replay(match, tmp_path / f"match{ending}", fps=20, start_s=0.0)  # without a title
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
