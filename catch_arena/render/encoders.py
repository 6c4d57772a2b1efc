"""Frames to a file: MP4, WebM, GIF or animated WebP by its ending, written frame by frame, and counted."""

import os
import tempfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import IO, Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from catch_arena.errors import ConfigError, OutputError, install_hint
from catch_arena.files import regular_file, room, unfinished_file, unwritable
from catch_arena.render.gif_palette import ColorHistogram
from catch_arena.render.optional_imports import cv2

Pixels = NDArray[np.uint8]
Progress = Callable[[int, int], None]
"""Called with (frames written, frames in all)."""


@dataclass(frozen=True, slots=True)
class Format:
    """One kind of file, and what is usual for it."""

    name: str
    container: str
    """FFmpeg's name."""
    encoder: str
    """FFmpeg's name."""
    codec: str
    size: tuple[int, int]
    fps: int
    most_fps: int = 240
    options: Mapping[str, str] = field(default_factory=dict)
    container_options: Mapping[str, str] = field(default_factory=dict)
    even: bool = True
    """It takes even widths and heights only."""


FORMATS: Final[Mapping[str, Format]] = MappingProxyType(
    {
        ".mp4": Format(
            "MP4",
            "mp4",
            "libx264",
            "h264",
            (1280, 720),
            60,
            # flat areas need no finer search: a fifth faster, and no larger
            options={"preset": "veryfast", "crf": "20", "x264-params": "subme=1:rc-lookahead=10"},
            container_options={"movflags": "+faststart"},
        ),
        ".webm": Format(
            "WebM",
            "webm",
            "libvpx-vp9",
            "vp9",
            (1280, 720),
            60,
            options={"deadline": "realtime", "cpu-used": "7", "row-mt": "1", "crf": "34", "b": "0"},
        ),
        # browsers show a GIF's frames for at least 20 ms, and its times are hundredths of a second
        ".gif": Format(
            "GIF", "gif", "gif", "gif", (640, 360), 25, most_fps=50, container_options={"loop": "0"}, even=False
        ),
        ".webp": Format(
            "animated WebP",
            "webp",
            "libwebp_anim",
            "webp",
            (640, 360),
            30,
            most_fps=100,
            options={"quality": "75", "compression_level": "4"},
            container_options={"loop": "0"},
        ),
    }
)
"""By the file's ending."""

_BT601: Final = 6
"""The matrix with which cv2 makes YUV of RGB (SMPTE 170M)."""
_BT709: Final = 1
"""Primaries and transfer: those of sRGB screens."""
_LIMITED: Final = 1
"""Luma from 16 to 235."""


def format_of(path: Path) -> Format:
    """What the file's ending stands for.

    Raises:
        ConfigError: for an ending that is none of FORMATS.
    """
    found = FORMATS.get(path.suffix.lower())
    if found is None:
        *others, last = FORMATS
        raise ConfigError(f"path must end in {', '.join(others)} or {last}, got {str(path)!r}")
    return found


def output_path(path: Path) -> Path:
    """The name that a video of this name gets: where its encoder is missing, .mp4 is added to another ending.

    Raises:
        ConfigError: for an ending that is none of FORMATS.
    """
    if path.suffix.lower() == ".mp4" or _pyav_with(format_of(path).encoder) is not None:
        return path
    return path.with_name(f"{path.name}.mp4")  # the full name: another MP4 file may stand beside it


class Encoder(Protocol):
    """A file that takes frames."""

    codec: str

    @property
    def failures(self) -> tuple[type[Exception], ...]:
        """What its methods raise when the file cannot be written or read back."""

    def write(self, pixels: Pixels) -> None:
        """One more frame: (height, width, 4), red, green, blue and a byte that means nothing."""

    def finish(self, progress: Progress | None) -> None:
        """No more frames: make the file whole; what takes long tells its progress."""

    def abort(self) -> None:
        """Let go of the file, in whatever state it is."""

    def count(self) -> int:
        """How many frames the finished file has."""


@dataclass(slots=True)
class VideoFile:
    """A video that is being written."""

    path: Path
    """Where it will be: under another ending than was asked for, where its encoder is missing."""
    codec: str
    write: Callable[[Pixels], None]
    """Takes one more frame: (height, width, 4), red, green, blue and a byte that means nothing."""
    notice: str = ""
    """One line for the user, if there is something to say."""


@contextmanager
def video_file(
    path: str | os.PathLike[str], size: tuple[int, int], fps: int, frames: int, progress: Progress | None = None
) -> Iterator[VideoFile]:
    """A video that appears under its name when all went well and it holds that many frames.

    Whatever is raised, Ctrl-C included, no half-written file is left, and what stood under the name stands there still.
    Without PyAV, or where its FFmpeg lacks the encoder, the file is MPEG-4 Part 2, and .mp4 is added to
    the name of one that would end otherwise.

    Args:
        path: whose ending is one of FORMATS.
        size: (width, height), even where the format asks for it.
        fps: frames a second, from 1 on.
        frames: the frames, (height, width, 3 or 4) uint8.
        progress: told of work that is left when the last frame has come.

    Raises:
        ConfigError: for an ending that is none of FORMATS.
        OutputError: where it cannot be written.
    """
    kind = format_of(Path(path))
    path = output_path(Path(path))
    av = _pyav_with(kind.encoder)
    notice = ""
    if av is None:
        notice = (
            f"{path} is MPEG-4 Part 2, which no browser plays: {kind.name} needs PyAV with {kind.encoder} "
            f"({install_hint('video')})"
        )
    failures: tuple[type[Exception], ...] = (OSError,)
    target = regular_file(path)
    try:
        with unfinished_file(target, ending=path.suffix) as unfinished:
            encoder = _Cv2Encoder(unfinished, size, fps) if av is None else _encoder(av, kind, unfinished, size, fps)
            failures = encoder.failures
            try:
                yield VideoFile(path, encoder.codec, encoder.write, notice)
                encoder.finish(progress)
                _require_frames(path, encoder.count(), frames)
            except BaseException:
                encoder.abort()
                raise
    except BaseException as error:
        if isinstance(error, failures):
            raise unwritable(path, error) from None
        raise


def _pyav_with(encoder: str) -> Any:
    """PyAV, if it is there and has that encoder: some distributions build it without."""
    try:
        import av
    except ImportError:
        return None
    return av if encoder in av.codecs_available else None


def _encoder(av: Any, kind: Format, path: Path, size: tuple[int, int], fps: int) -> Encoder:
    makers: dict[str, type[_YuvEncoder | _GifEncoder]] = {"gif": _GifEncoder, "webp": _WebpEncoder}
    return makers.get(kind.codec, _YuvEncoder)(av, kind, path, size, fps)


def _require_frames(path: Path, counted: int, frames: int) -> None:
    if counted != frames:
        raise OutputError(
            f"{path}: cannot be written: {counted} of {frames} frames could be read back; is the disk full? "
            f"{room(path.parent)}"
        )


class _AvEncoder:
    """A file through PyAV."""

    def __init__(self, av: Any, kind: Format, path: Path, size: tuple[int, int], fps: int) -> None:
        self.codec = kind.codec
        self.failures = (OSError, av.error.FFmpegError)
        self._av = av
        self._path = path
        self._size = size
        self._written = 0
        self._time_base = Fraction(1, fps)
        self._form = kind.container
        # the format is given: in a name, FFmpeg takes %d for the number of a picture
        self._container = av.open(str(path), "w", format=self._form, options=dict(kind.container_options))
        self._stream = self._container.add_stream(kind.encoder, rate=fps, options=dict(kind.options))
        self._stream.width, self._stream.height = size
        self._stream.codec_context.time_base = self._time_base
        self._stream.codec_context.gop_size = 2 * fps  # players jump to these frames

    def _encode(self, frame: Any) -> None:
        frame.pts, frame.time_base = self._written, self._time_base
        self._container.mux(self._stream.encode(frame))
        self._written += 1

    def finish(self, progress: Progress | None) -> None:
        del progress
        self._container.mux(self._stream.encode(None))
        self._container.close()

    def abort(self) -> None:
        with suppress(*self.failures):  # a full disk fails again when its file is closed
            self._container.close()

    def count(self) -> int:
        with self._av.open(str(self._path), format=self._form) as container:
            return sum(packet.size > 0 for packet in container.demux(video=0))


class _YuvEncoder(_AvEncoder):
    """yuv420p with its colours said: what browsers and players take."""

    def __init__(self, av: Any, kind: Format, path: Path, size: tuple[int, int], fps: int) -> None:
        super().__init__(av, kind, path, size, fps)
        self._stream.pix_fmt = "yuv420p"
        context = self._stream.codec_context
        context.colorspace, context.color_range = _BT601, _LIMITED
        context.color_primaries, context.color_trc = _BT709, _BT709

    def write(self, pixels: Pixels) -> None:
        planes = cv2.cvtColor(pixels, cv2.COLOR_RGBA2YUV_I420)
        frame = self._av.VideoFrame.from_ndarray(planes, format="yuv420p")
        frame.colorspace, frame.color_range = _BT601, _LIMITED
        self._encode(frame)


class _WebpEncoder(_YuvEncoder):
    """FFmpeg writes animations but reads none, and frames that look alike become one: their times are counted."""

    def count(self) -> int:
        content = self._path.read_bytes()
        milliseconds, at = 0, 12
        while at + 24 <= len(content):
            name, length = content[at : at + 4], int.from_bytes(content[at + 4 : at + 8], "little")
            if name.startswith(b"VP8") and name != b"VP8X":
                return self._written  # all alike: a picture that does not move
            if name == b"ANMF" and at + 8 + length <= len(content):
                milliseconds += int.from_bytes(content[at + 20 : at + 23], "little")
            at += 8 + length + length % 2
        return round(milliseconds / 1000.0 / self._time_base)


class _GifEncoder(_AvEncoder):
    """256 colours for all of the frames, which must be known before the palette is.

    Until then they wait in a temporary file, as 16-bit colours: memory does not grow with the length.
    """

    def __init__(self, av: Any, kind: Format, path: Path, size: tuple[int, int], fps: int) -> None:
        super().__init__(av, kind, path, size, fps)
        self._stream.pix_fmt = "pal8"
        self._waiting: IO[bytes] = tempfile.TemporaryFile(dir=path.parent)  # noqa: SIM115 - closed by finish or abort
        self._lengths: list[int] = []
        self._histogram = ColorHistogram()

    def write(self, pixels: Pixels) -> None:
        squeezed = zlib.compress(self._histogram.count(pixels).tobytes(), 1)
        self._lengths.append(len(squeezed))
        self._waiting.write(squeezed)

    def finish(self, progress: Progress | None) -> None:
        palette, indices = self._histogram.palette()
        width, height = self._size
        self._waiting.seek(0)
        for done, length in enumerate(self._lengths, start=1):
            codes = np.frombuffer(zlib.decompress(self._waiting.read(length)), dtype=np.uint16)
            self._encode(self._av.VideoFrame.from_ndarray((indices[codes].reshape(height, width), palette), "pal8"))
            if progress is not None:
                progress(done, len(self._lengths))
        self._waiting.close()
        super().finish(progress)

    def abort(self) -> None:
        with suppress(*self.failures):
            self._waiting.close()
        super().abort()


class _Cv2Encoder:
    """MPEG-4 Part 2 through cv2, for those who have no PyAV."""

    codec = "mpeg4"
    failures = (OSError, cv2.error)

    def __init__(self, path: Path, size: tuple[int, int], fps: int) -> None:
        self._path = path
        self._even = (size[0] + size[0] % 2, size[1] + size[1] % 2)
        self._writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), float(fps), self._even)
        if not self._writer.isOpened():
            raise OSError("no encoder could be opened")

    def write(self, pixels: Pixels) -> None:
        height, width = pixels.shape[:2]
        right, below = self._even[0] - width, self._even[1] - height
        if right or below:  # cv2 drops frames of another size without a word
            pixels = np.asarray(cv2.copyMakeBorder(pixels, 0, below, 0, right, cv2.BORDER_REPLICATE), dtype=np.uint8)
        self._writer.write(cv2.cvtColor(pixels, cv2.COLOR_RGBA2BGR))

    def finish(self, progress: Progress | None) -> None:
        del progress
        self._writer.release()

    def abort(self) -> None:
        self._writer.release()

    def count(self) -> int:
        reader = cv2.VideoCapture(str(self._path))
        frames = 0
        while reader.grab():
            frames += 1
        reader.release()
        return frames
