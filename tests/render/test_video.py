"""The MP4 file: decoded again, counted, and never half there."""

import builtins
import json
import os
import subprocess
import sys
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from catch_arena.errors import ConfigError, OutputError, ReplayError
from catch_arena.render import scene
from catch_arena.render.motion import passages
from catch_arena.render.raster import Stage
from catch_arena.render.video import NO_AV_NOTICE, frame_count, render_replay

SMALL = {"size": (480, 320), "fps": 30}


def decoded(path: Path) -> list[np.ndarray]:
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


def drawn(replay, size, fps, layout="broadcast") -> list[np.ndarray]:
    duration_ms = replay.steps * replay.config.control_period_ms
    stage = Stage(scene.Look.of(replay.config, replay.names, replay.title, duration_ms), size, layout, replay.seed)
    frames = []
    for passage in passages(replay.worlds(), fps, frame_count(duration_ms, fps)):
        stage.enter(passage.leg)
        for frame in passage.frames:
            time_ms = 1000.0 * frame / fps
            frames.append(stage.draw(passage.leg, time_ms, passage.leg.at(time_ms, passage.next_tick))[..., :3].copy())
    return frames


def psnr(one: np.ndarray, other: np.ndarray) -> float:
    return float(10 * np.log10(255.0**2 / np.mean((one.astype(float) - other.astype(float)) ** 2)))


def boxes(path: Path) -> list[str]:
    """The names of an MP4 file's boxes, in order."""
    content, names, at = path.read_bytes(), [], 0
    while at < len(content):
        size = int.from_bytes(content[at : at + 4], "big")
        names.append(content[at + 4 : at + 8].decode())
        assert size >= 8
        at += size
    return names


@pytest.mark.parametrize("layout", ["broadcast", "arena"])
def test_the_file_shows_the_frames_that_were_drawn_and_all_of_them(match, tmp_path, layout):
    report = render_replay(match, tmp_path / "match.mp4", layout=layout, **SMALL)
    seen, meant = decoded(report.path), drawn(match, layout=layout, **SMALL)
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


def test_colours_come_back_as_they_were(match, tmp_path):
    report = render_replay(match, tmp_path / "match.mp4", **SMALL)
    ground = decoded(report.path)[0][4:9, 100:105].reshape(-1, 3).mean(axis=0)
    assert ground == pytest.approx(drawn(match, **SMALL)[0][4:9, 100:105].reshape(-1, 3).mean(axis=0), abs=3.0)


def test_browsers_can_play_it_while_it_loads(match, tmp_path):
    path = render_replay(match, tmp_path / "match.mp4", **SMALL).path
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


@pytest.mark.parametrize(
    ("duration_ms", "fps", "frames"),
    [(60_000, 60, 3600), (0, 60, 1), (100, 60, 6), (48, 60, 3), (25, 60, 2), (1, 1, 1), (33, 30, 1)],
)
def test_the_video_is_as_long_as_the_match(duration_ms, fps, frames):
    assert frame_count(duration_ms, fps) == frames
    assert (frames - 1) / fps * 1000 <= duration_ms


@pytest.mark.parametrize(
    ("size", "even"), [((321, 321), (322, 322)), ((400, 335), (400, 336)), ((320, 320), (320, 320))]
)
def test_odd_sizes_become_the_next_even_ones(play, tmp_path, size, even):
    report = render_replay(play("duel", max_cycles=2), tmp_path / "odd.mp4", size=size, fps=10)
    assert report.size == even
    assert [frame.shape for frame in decoded(report.path)] == [(even[1], even[0], 3)] * 2


def test_a_match_without_steps_is_one_frame(tmp_path, play):
    replay = play("duel", max_cycles=1)
    replay.choices.clear()
    replay.commands.clear()
    del replay.digests[1:]
    assert render_replay(replay, tmp_path / "none.mp4", **SMALL).frames == 1


def test_progress_is_told_frame_by_frame(match, tmp_path):
    told = []
    render_replay(match, tmp_path / "match.mp4", progress=lambda done, total: told.append((done, total)), **SMALL)
    assert told == [(frame, 90) for frame in range(1, 91)]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"size": (100, 100)}, r"size must be two whole numbers from 320 x 320 to 3840 x 2160, got \(100, 100\)"),
        ({"fps": 0}, "fps must be a whole number from 1 to 240, got 0"),
        ({"fps": 59.94}, "fps must be a whole number from 1 to 240, got 59.94"),
        ({"layout": "brodcast"}, "layout must be broadcast or arena, got 'brodcast'; did you mean broadcast"),
    ],
)
def test_settings_that_cannot_be(match, tmp_path, settings, message):
    with pytest.raises(ConfigError, match=message):
        render_replay(match, tmp_path / "match.mp4", **settings)
    assert list(tmp_path.iterdir()) == []


def test_another_kind_of_file_is_not_promised(match, tmp_path):
    with pytest.raises(ConfigError, match=r"path must end in \.mp4, got"):
        render_replay(match, tmp_path / "match.gif")


def test_places_that_cannot_be_written_to(match, tmp_path):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.mp4").mkdir()
    for path in (tmp_path / "missing" / "match.mp4", tmp_path / "file" / "match.mp4", tmp_path / "folder.mp4"):
        with pytest.raises(OutputError, match=r"\.mp4: cannot be written: "):
            render_replay(match, path, **SMALL)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder.mp4"]


def test_a_folder_without_permission(match):
    """Not even root may make a file in /proc."""
    with pytest.raises(OutputError, match=r"match\.mp4: cannot be written: "):
        render_replay(match, Path("/proc/match.mp4"), **SMALL)


@pytest.mark.parametrize("trouble", [KeyboardInterrupt, ReplayError("step 9 is the first that differs")])
def test_whatever_happens_on_the_way_the_old_file_stays_and_no_half_one(match, tmp_path, trouble):
    (tmp_path / "match.mp4").write_text("what stood here before")

    def stop(done: int, total: int) -> None:
        if done == total // 2:
            raise trouble

    with pytest.raises(trouble if isinstance(trouble, type) else type(trouble)):
        render_replay(match, tmp_path / "match.mp4", progress=stop, **SMALL)
    assert [path.name for path in tmp_path.iterdir()] == ["match.mp4"]
    assert (tmp_path / "match.mp4").read_text() == "what stood here before"


_FULL_DISK = """
import json, resource, sys
from pathlib import Path
if sys.argv[3] == "plain":
    sys.modules["av"] = None
from catch_arena import Replay
from catch_arena.errors import OutputError
from catch_arena.render.video import render_replay
replay = Replay.load(sys.argv[1])
folder = Path(sys.argv[2])
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[4]), resource.RLIM_INFINITY))
try:
    render_replay(replay, folder / "match.mp4", size=(480, 320), fps=30)
    said = ""
except OutputError as error:
    said = str(error)
print(json.dumps([said, sorted(path.name for path in folder.iterdir())]))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no RLIMIT_FSIZE")
@pytest.mark.parametrize("limit", [0, 4_000, 40_000, "almost"])
@pytest.mark.parametrize("encoder", ["h264", "plain"])
def test_a_full_disk_is_an_error_and_leaves_nothing(match, tmp_path, encoder, limit):
    """A process whose files may not grow beyond a limit meets the same write errors as one on a full disk."""
    whole = tmp_path / "whole"
    whole.mkdir()
    match.save(tmp_path / "match.replay")

    def run(folder: Path, most: int) -> tuple[str, list[str]]:
        arguments = [str(tmp_path / "match.replay"), str(folder), encoder, str(most)]
        paths = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
        done = subprocess.run(
            [sys.executable, "-c", _FULL_DISK, *arguments], capture_output=True, text=True, check=False, env=paths
        )
        assert done.returncode == 0, done.stderr
        said, left = json.loads(done.stdout.splitlines()[-1])
        return said, left

    if limit == "almost":  # the last bytes are the index
        assert run(whole, 1 << 40) == ("", ["match.mp4"])
        limit = (whole / "match.mp4").stat().st_size - 100
    folder = tmp_path / "full"
    folder.mkdir()
    said, left = run(folder, limit)
    assert "match.mp4: cannot be written: " in said
    assert left == []


def test_without_pyav_there_is_a_plainer_file_and_a_notice(match, tmp_path, monkeypatch):
    real = builtins.__import__

    def no_av(name, *rest):
        if name == "av" or name.startswith("av."):
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", no_av)
    report = render_replay(match, tmp_path / "match.mp4", **SMALL)
    monkeypatch.undo()
    assert (report.codec, report.notice, report.frames) == ("mpeg4", NO_AV_NOTICE, 90)
    assert "\n" not in report.notice
    seen, meant = decoded(report.path), drawn(match, **SMALL)
    assert len(seen) == 90
    assert min(psnr(a, b) for a, b in zip(seen, meant, strict=True)) > 22.0


def test_the_script_says_what_it_wrote_and_what_it_could_not(match, tmp_path):
    match.save(tmp_path / "match.replay")
    script = Path(__file__).parents[2] / "scripts" / "render.py"
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, str(script), *arguments],
            capture_output=True,
            text=True,
            check=False,
            env=paths,
            cwd=tmp_path,
        )

    done = run("match.replay", "-o", "out.mp4", "--size", "320x320", "--fps", "10")
    assert (done.returncode, done.stdout.strip()) == (0, "video: out.mp4 (30 frames, 3 s)")
    assert len(decoded(tmp_path / "out.mp4")) == 30
    (tmp_path / "broken.replay").write_bytes((tmp_path / "match.replay").read_bytes()[:100])
    done = run("broken.replay", "-o", "broken.mp4")
    assert (done.returncode, done.stdout.strip()) == (2, "")
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "broken.mp4").exists()
