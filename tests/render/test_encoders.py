"""The file of a video: whole, or not there at all."""

import json
import os
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from render.videos import ENDINGS, SMALL, decoded

from catch_arena.errors import OutputError, ReplayError
from catch_arena.render.encoders import video_file
from catch_arena.render.video import render_replay


def test_a_picture_in_which_nothing_happens_has_all_its_frames_too(tmp_path):
    """Encoders that merge what looks alike are no reason to call a file incomplete."""
    still = np.full((320, 480, 4), 77, dtype=np.uint8)
    for ending in ENDINGS:
        with video_file(tmp_path / f"still{ending}", (480, 320), 30) as video:
            for _ in range(45):
                video.write(still)
        assert np.abs(decoded(video.path)[-1].astype(int) - 77).max() <= 2


def test_places_that_cannot_be_written_to(match, tmp_path):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.mp4").mkdir()
    for path in (tmp_path / "missing" / "match.mp4", tmp_path / "file" / "match.mp4", tmp_path / "folder.mp4"):
        with pytest.raises(OutputError, match=r"\.mp4: cannot be written: "):
            render_replay(match, path, **SMALL)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder.mp4"]


@pytest.mark.parametrize("ending", ENDINGS)
def test_any_name_that_the_disk_allows_is_a_videos(match, tmp_path, ending):
    """FFmpeg takes %d for the number of a picture, and a name before a colon for a protocol."""
    folder = tmp_path / "run%d"
    folder.mkdir()
    for name in (f"seed%d{ending}", f"http:{ending}", ending.rjust(255, "x")):
        video = render_replay(match, folder / name, **SMALL)
        assert len(decoded(video.path)) > 1
        assert [path.name for path in folder.iterdir()] == [name]
        video.path.unlink()


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_video_has_the_permissions_that_the_umask_leaves_or_those_of_the_file_that_it_replaces(tmp_path, ending):
    path = tmp_path / f"still{ending}"
    umask = os.umask(0o037)
    try:
        for mode in (0o640, 0o604):
            with video_file(path, (480, 320), 30) as video:
                video.write(np.zeros((320, 480, 4), dtype=np.uint8))
            assert stat.S_IMODE(path.stat().st_mode) == mode
            path.chmod(0o604)
    finally:
        os.umask(umask)


def test_a_folder_without_permission(match):
    """Not even root may make a file in /proc."""
    with pytest.raises(OutputError, match=r"match\.mp4: cannot be written: "):
        render_replay(match, Path("/proc/match.mp4"), **SMALL)


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("trouble", [KeyboardInterrupt, ReplayError("step 9 is the first that differs")])
def test_whatever_happens_on_the_way_the_old_file_stays_and_no_half_one(match, tmp_path, trouble, ending):
    (tmp_path / f"match{ending}").write_text("what stood here before")

    def stop(done: int, total: int) -> None:
        if done == total // 2:
            raise trouble

    with pytest.raises(trouble if isinstance(trouble, type) else type(trouble)):
        render_replay(match, tmp_path / f"match{ending}", progress=stop, size=SMALL["size"], fps=10)
    assert [path.name for path in tmp_path.iterdir()] == [f"match{ending}"]
    assert (tmp_path / f"match{ending}").read_text() == "what stood here before"


_FULL_DISK = """
import json, resource, sys
from pathlib import Path
from catch_arena import Replay
from catch_arena.errors import OutputError
from catch_arena.render.video import render_replay
replay, (_, most) = Replay.load(sys.argv[1]), resource.getrlimit(resource.RLIMIT_FSIZE)
found = {}
for ending in sys.argv[2:]:
    folder = Path(ending)
    folder.mkdir()
    video = render_replay(replay, folder / f"match{ending}", size=(480, 320), fps=10).path
    almost = video.stat().st_size - 100
    video.unlink()
    for limit in (0, 20_000, almost):
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, most))
        try:
            render_replay(replay, folder / f"match{ending}", size=(480, 320), fps=10)
            said = ""
        except OutputError as error:
            said = str(error)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
        found[f"{ending}, {limit} of {almost + 100} bytes"] = said, [path.name for path in folder.iterdir()]
print(json.dumps(found))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no RLIMIT_FSIZE")
def test_a_full_disk_is_an_error_and_leaves_nothing(match, tmp_path):
    """A process whose files may not grow beyond a limit meets the same write errors as one on a full disk; the last
    bytes that a file lacks are those of its index.
    """
    match.save(tmp_path / "match.replay")
    done = subprocess.run(
        [sys.executable, "-c", _FULL_DISK, "match.replay", *ENDINGS],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    assert len(found) == 3 * len(ENDINGS)
    for case, (said, left) in found.items():
        assert ": cannot be written: " in said, case
        assert left == [], case


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


@pytest.mark.parametrize("ending", [".mp4", ".gif"])
def test_ctrl_c_leaves_nothing_behind(play, tmp_path, ending):
    play(time_limit_s=30.0).save(tmp_path / "match.replay")
    script = Path(__file__).parents[2] / "scripts" / "render.py"
    command = [sys.executable, str(script), "match.replay", "-o", f"out{ending}", "--fps", "50", "--size", "640x360"]
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(command, cwd=tmp_path, env=paths, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        deadline = time.monotonic() + 240.0
        while not list(tmp_path.glob(f".catch-arena-*{ending}")) and time.monotonic() < deadline:
            time.sleep(0.02)
        assert list(tmp_path.glob(f".catch-arena-*{ending}"))  # it has begun to write
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=240.0)
    assert process.returncode not in (0, None)
    assert b"Traceback" not in said
    assert [path.name for path in tmp_path.iterdir()] == ["match.replay"]
