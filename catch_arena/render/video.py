"""A match as an MP4 file: H.264 that a browser plays, written frame by frame, and counted before it gets its name."""

import os
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Final, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from catch_arena.errors import ConfigError, OutputError
from catch_arena.render import hud, scene
from catch_arena.render.motion import passages
from catch_arena.render.raster import Stage, checked_size
from catch_arena.replay import Replay, regular_file

Pixels = NDArray[np.uint8]

MOST_FPS: Final = 240
NO_AV_NOTICE: Final = (
    "the video is MPEG-4 Part 2, which no browser plays: PyAV with H.264 is missing (pip install 'catch-arena[video]')"
)

_BT601: Final = 6
"""The matrix with which cv2 makes YUV of RGB (SMPTE 170M)."""
_BT709: Final = 1
"""Primaries and transfer: those of sRGB screens."""
_LIMITED: Final = 1
"""Luma from 16 to 235."""


@dataclass(frozen=True, slots=True)
class RenderReport:
    """What was written."""

    path: Path
    frames: int
    """Counted in the finished file."""
    seconds: float
    """The video's length."""
    size: tuple[int, int]
    """(width, height) [pixels]; an odd number asked for has become the next even one."""
    fps: int
    codec: str
    """"h264", or "mpeg4" where PyAV is missing."""
    bytes: int
    elapsed_s: float
    """How long it took."""
    notice: str = ""
    """One line for the user, if there is something to say."""


def frame_count(duration_ms: int, fps: int) -> int:
    """How many frames a match has: duration * fps, rounded half up, at least 1; frame k shows the instant k / fps."""
    return max(1, (2 * duration_ms * fps + 1000) // 2000)


def render_replay(
    replay: Replay,
    path: str | os.PathLike[str],
    *,
    size: tuple[int, int] = (1280, 720),
    fps: int = 60,
    layout: hud.Layout = "broadcast",
    progress: Callable[[int, int], None] | None = None,
) -> RenderReport:
    """Write a match as an MP4 file that spans it and nothing before or after: `frame_count(duration_ms, fps)` frames.

    Args: `path`, which must end in .mp4; `size`, (width, height) from 320 x 320 to 3840 x 2160, of which H.264 needs
    even numbers: an odd one becomes the next even one; `fps`, 1 to 240; `layout`, "broadcast" (arena, standings,
    timeline) or "arena"; `progress`, called with (frames written, frames in all).
    Raises: ConfigError for a setting that cannot be, OutputError where the file cannot be written, ReplayError where
    the replay does not play as recorded. Whatever is raised, Ctrl-C included, no half-written file is left, and what
    stood under the name before stands there still.
    """
    began = time.perf_counter()
    path = Path(path)
    if path.suffix.lower() != ".mp4":
        raise ConfigError(f"path must end in .mp4, got {str(path)!r}")
    if isinstance(fps, bool) or not isinstance(fps, int) or not 1 <= fps <= MOST_FPS:
        raise ConfigError(f"fps must be a whole number from 1 to {MOST_FPS}, got {fps!r}")
    width, height = checked_size(size)
    even = (width + width % 2, height + height % 2)
    duration_ms = replay.steps * replay.config.control_period_ms
    frames = frame_count(duration_ms, fps)
    stage = Stage(scene.Look.of(replay.config, replay.names, replay.title, duration_ms), even, layout, replay.seed)
    with mp4_file(path, even, fps, frames) as video:
        for passage in passages(replay.worlds(), fps, frames):
            leg = passage.leg
            stage.enter(leg)
            for frame in passage.frames:
                time_ms = 1000.0 * frame / fps
                video.write(stage.draw(leg, time_ms, leg.at(time_ms, passage.next_tick)))
                if progress is not None:
                    progress(frame + 1, frames)
    return RenderReport(
        path=path,
        frames=frames,
        seconds=frames / fps,
        size=even,
        fps=fps,
        codec=video.codec,
        bytes=path.stat().st_size,
        elapsed_s=time.perf_counter() - began,
        notice=video.notice,
    )


class Encoder(Protocol):
    """A file that takes frames."""

    codec: str
    notice: str

    @property
    def failures(self) -> tuple[type[Exception], ...]:
        """What its methods raise when the file cannot be written or read back."""

    def write(self, pixels: Pixels) -> None:
        """One more frame: (height, width, 4), red, green, blue and a byte that means nothing."""

    def finish(self) -> None:
        """No more frames: make the file whole."""

    def abandon(self) -> None:
        """Let go of the file, in whatever state it is."""

    def count(self) -> int:
        """Decode the finished file: how many frames it has."""


@contextmanager
def mp4_file(path: Path, size: tuple[int, int], fps: int, frames: int) -> Iterator[Encoder]:
    """An MP4 file that appears under its name when all went well and it holds that many frames. Raises: OutputError."""
    target = regular_file(path)
    try:
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{path.stem}.", suffix=".part.mp4")
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from None
    os.close(handle)
    unfinished = Path(name)
    encoder: Encoder | None = None
    try:
        encoder = _encoder(unfinished, size, fps)
        yield encoder
        encoder.finish()
        _require_frames(path, encoder.count(), frames)
        unfinished.chmod(0o644)  # mkstemp's files are for their owner alone
        unfinished.replace(target)
    except BaseException as error:
        if encoder is not None:
            encoder.abandon()
        unfinished.unlink(missing_ok=True)
        if isinstance(error, (OSError,) if encoder is None else encoder.failures):
            raise OutputError(f"{path}: cannot be written: {getattr(error, 'strerror', None) or error}") from None
        raise


def _require_frames(path: Path, counted: int, frames: int) -> None:
    if counted != frames:
        raise OutputError(
            f"{path}: cannot be written: {counted} of {frames} frames could be read back; is the disk full?"
        )


def _encoder(path: Path, size: tuple[int, int], fps: int) -> Encoder:
    try:
        import av
    except ImportError:
        return _PlainEncoder(path, size, fps)
    if "libx264" not in av.codecs_available:  # some distributions build it without
        return _PlainEncoder(path, size, fps)
    return _H264Encoder(av, path, size, fps)


class _H264Encoder:
    """H.264 through PyAV: yuv420p, its index in front, and its colours said."""

    codec = "h264"
    notice = ""

    def __init__(self, av: Any, path: Path, size: tuple[int, int], fps: int) -> None:
        self.failures = (OSError, av.error.FFmpegError)
        self._av = av
        self._path = path
        self._written = 0
        self._time_base = Fraction(1, fps)
        self._container = av.open(str(path), "w", format="mp4", options={"movflags": "+faststart"})
        options = {"preset": "veryfast", "crf": "20", "g": str(2 * fps)}
        self._stream = self._container.add_stream("libx264", rate=fps, options=options)
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = "yuv420p"
        context = self._stream.codec_context
        context.time_base = self._time_base
        context.colorspace, context.color_range = _BT601, _LIMITED
        context.color_primaries, context.color_trc = _BT709, _BT709

    def write(self, pixels: Pixels) -> None:
        planes = cv2.cvtColor(pixels, cv2.COLOR_RGBA2YUV_I420)
        frame = self._av.VideoFrame.from_ndarray(planes, format="yuv420p")
        frame.pts, frame.time_base = self._written, self._time_base
        frame.colorspace, frame.color_range = _BT601, _LIMITED
        self._container.mux(self._stream.encode(frame))
        self._written += 1

    def finish(self) -> None:
        self._container.mux(self._stream.encode(None))
        self._container.close()

    def abandon(self) -> None:
        with suppress(*self.failures):  # a full disk fails again when its file is closed
            self._container.close()

    def count(self) -> int:
        with self._av.open(str(self._path)) as container:
            stream = container.streams.video[0]
            stream.thread_type = "AUTO"
            return sum(1 for _ in container.decode(stream))


class _PlainEncoder:
    """MPEG-4 Part 2 through cv2, for those who have no PyAV."""

    codec = "mpeg4"
    notice = NO_AV_NOTICE
    failures = (OSError, cv2.error)

    def __init__(self, path: Path, size: tuple[int, int], fps: int) -> None:
        self._path = path
        self._writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), float(fps), size)
        if not self._writer.isOpened():
            raise OSError("no encoder could be opened")

    def write(self, pixels: Pixels) -> None:
        self._writer.write(cv2.cvtColor(pixels, cv2.COLOR_RGBA2BGR))

    def finish(self) -> None:
        self._writer.release()

    def abandon(self) -> None:
        self._writer.release()

    def count(self) -> int:
        reader = cv2.VideoCapture(str(self._path))
        frames = 0
        while reader.grab():
            frames += 1
        reader.release()
        return frames
