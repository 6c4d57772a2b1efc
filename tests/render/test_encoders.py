"""A video file is complete or does not exist, whatever interrupts the encoder."""

import json
import os
import stat
import subprocess
import sys

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
        path = tmp_path / f"still{ending}"
        with video_file(path, (480, 320), 30) as video:
            for _ in range(45):
                video.write(still)
        assert np.abs(decoded(path)[-1].astype(int) - 77).max() <= 2


def test_places_that_cannot_be_written_to(match, tmp_path):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.mp4").mkdir()
    for path in (tmp_path / "missing" / "match.mp4", tmp_path / "file" / "match.mp4", tmp_path / "folder.mp4"):
        with pytest.raises(OutputError, match=r"\.mp4: cannot be written: "):
            render_replay(match, path, **SMALL)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder.mp4"]


@pytest.mark.parametrize("ending", ENDINGS)
def test_any_name_that_the_disk_allows_is_a_videos(tmp_path, ending):
    """FFmpeg takes %d for the number of a picture, and a name before a colon for a protocol."""
    folder = tmp_path / "run%d"
    folder.mkdir()
    for name in (f"seed%d{ending}", f"http:{ending}", ending.rjust(255, "x")):
        with video_file(folder / name, (480, 320), 30) as video:
            for shade in (0, 100, 200):
                video.write(np.full((320, 480, 4), shade, dtype=np.uint8))
        assert len(decoded(folder / name)) == 3
        assert [path.name for path in folder.iterdir()] == [name]
        (folder / name).unlink()


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
    video = render_replay(replay, folder / f"match{ending}", size=(480, 320), fps=4).path
    almost = video.stat().st_size - 100
    video.unlink()
    for limit in (0, 20_000, almost):
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, most))
        try:
            render_replay(replay, folder / f"match{ending}", size=(480, 320), fps=4)
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
    for case, (error, left) in found.items():
        assert ": cannot be written: " in error, case
        assert left == [], case
