"""Video files: MP4, WebM, GIF or animated WebP by the file's ending, written frame by frame with PyAV."""

import gzip
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

import numpy as np

from catch_arena.errors import ConfigError, install_hint
from catch_arena.files import unfinished_file
from catch_arena.render.optional_imports import cv2
from catch_arena.render.raster import Pixels

Progress = Callable[[int, int], None]
"""Function that is called with (frames written, frames in all)."""


@dataclass(frozen=True, slots=True)
class Format:
    """One kind of video file, and its defaults."""

    name: str
    encoder: str
    """Name of the encoder in FFmpeg."""
    size: tuple[int, int]
    fps: int
    most_fps: int = 240
    options: Mapping[str, str] = field(default_factory=dict)
    container_options: Mapping[str, str] = field(default_factory=dict)
    even: bool = True
    """True if the format takes even widths and heights only."""


FORMATS: Final[Mapping[str, Format]] = {
    ".mp4": Format(
        "MP4",
        "libx264",
        (1280, 720),
        60,
        # flat areas need no finer search: encoding is faster, and files are no larger
        options={"preset": "veryfast", "crf": "20", "x264-params": "subme=1:rc-lookahead=10"},
        container_options={"movflags": "+faststart"},
    ),
    ".webm": Format(
        "WebM",
        "libvpx-vp9",
        (1280, 720),
        60,
        options={"deadline": "realtime", "cpu-used": "7", "row-mt": "1", "crf": "34", "b": "0"},
    ),
    # browsers show a GIF's frames for at least 20 ms, and its times are hundredths of a second
    ".gif": Format("GIF", "gif", (640, 360), 25, most_fps=50, container_options={"loop": "0"}, even=False),
    ".webp": Format(
        "animated WebP",
        "libwebp_anim",
        (640, 360),
        30,
        most_fps=100,
        options={"quality": "75", "compression_level": "4"},
        container_options={"loop": "0"},
    ),
}
"""Formats by the file's ending, which without its dot is the name of the container in FFmpeg."""

_BT601: Final = 6
"""Matrix with which cv2 converts RGB to YUV (SMPTE 170M)."""
_BT709: Final = 1
"""Primaries and transfer function of sRGB screens."""
_LIMITED: Final = 1
"""Range of luma from 16 to 235."""


def format_of(path: Path) -> Format:
    """Return the format that a file's ending stands for; raise ConfigError for an ending that is none of FORMATS."""
    found = FORMATS.get(path.suffix.lower())
    if found is None:
        *endings, last = FORMATS
        raise ConfigError(f"path must end in {', '.join(endings)} or {last}, got {str(path)!r}")
    return found


class VideoFile:
    """Video that is being written, in yuv420p with its colour space declared, as browsers and players need it."""

    _pixel_format = "yuv420p"

    def __init__(self, path: Path, kind: Format, size: tuple[int, int], fps: int) -> None:
        self._av = _pyav(kind)
        self._size = size
        self._written = 0
        self._time_base = Fraction(1, fps)
        # the format is given: FFmpeg reads %d in a name as the number of a picture
        container, options = path.suffix[1:].lower(), dict(kind.container_options)
        self._container = self._av.open(str(path), "w", format=container, options=options)
        self._stream = self._container.add_stream(kind.encoder, rate=fps, options=dict(kind.options))
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = self._pixel_format
        context = self._stream.codec_context
        context.time_base = self._time_base
        context.thread_type = "FRAME"  # encode on other cores while the next frames are drawn
        context.gop_size = 2 * fps  # players jump to these frames
        if self._pixel_format == "yuv420p":
            context.colorspace, context.color_range = _BT601, _LIMITED
            context.color_primaries, context.color_trc = _BT709, _BT709

    def write(self, pixels: Pixels) -> None:
        """Write one more frame of shape (height, width, 4): red, green, blue and an unused byte."""
        planes = cv2.cvtColor(pixels, cv2.COLOR_RGBA2YUV_I420)
        frame = self._av.VideoFrame.from_ndarray(planes, format="yuv420p")
        frame.colorspace, frame.color_range = _BT601, _LIMITED
        self._encode(frame)

    def finish(self) -> None:
        """Complete the file after the last frame, and close it."""
        self._container.mux(self._stream.encode(None))
        self.close()

    def close(self) -> None:
        """Close the file, complete or not."""
        self._container.close()

    def _encode(self, frame: Any) -> None:
        frame.pts, frame.time_base = self._written, self._time_base
        self._container.mux(self._stream.encode(frame))
        self._written += 1


class _GifFile(VideoFile):
    """GIF that is being written; its one palette is known after FFmpeg's palettegen has seen all frames.

    Until then frames wait in a temporary file, so memory does not grow with the length.
    """

    _pixel_format = "pal8"

    def __init__(self, path: Path, kind: Format, size: tuple[int, int], fps: int) -> None:
        super().__init__(path, kind, size, fps)
        self._waiting = tempfile.TemporaryFile(dir=path.parent)  # noqa: SIM115 - `close` closes it
        self._packed = gzip.GzipFile(fileobj=self._waiting, mode="wb", compresslevel=1)
        self._palette, _ = self._graph("palettegen", "", ("rgb24", *size))

    def write(self, pixels: Pixels) -> None:
        picture = cv2.cvtColor(pixels, cv2.COLOR_RGBA2RGB)
        self._packed.write(picture.data)
        self._palette.push(self._av.VideoFrame.from_ndarray(picture, format="rgb24"))

    def finish(self) -> None:
        self._packed.close()
        self._waiting.seek(0)
        self._palette.push(None)
        palette, (width, height) = self._palette.pull(), self._size
        # without dithering, areas of one colour keep one colour
        graph, (frames, colors) = self._graph(
            "paletteuse", "dither=none", ("rgb24", width, height), (palette.format.name, palette.width, palette.height)
        )
        colors.push(palette)
        colors.push(None)
        packed = gzip.GzipFile(fileobj=self._waiting)
        for number, content in enumerate(iter(lambda: packed.read(3 * width * height), b"")):
            picture = np.frombuffer(content, np.uint8).reshape(height, width, 3)
            frame = self._av.VideoFrame.from_ndarray(picture, format="rgb24")
            frame.pts, frame.time_base = number, self._time_base
            frames.push(frame)
            self._encode_ready(graph)
        frames.push(None)
        self._encode_ready(graph)
        super().finish()

    def close(self) -> None:
        with suppress(OSError):  # the disk may be full
            self._packed.close()
        self._waiting.close()
        super().close()

    def _graph(self, name: str, options: str, *inputs: tuple[str, int, int]) -> tuple[Any, list[Any]]:
        """Return a graph of one filter, and its inputs, each given by its pixel format, width and height."""
        graph, sources = self._av.filter.Graph(), []
        used, output = graph.add(name, options), graph.add("buffersink")
        for place, (pixel_format, width, height) in enumerate(inputs):
            kind = self._av.VideoFormat(pixel_format)
            source = graph.add_buffer(width=width, height=height, format=kind, time_base=self._time_base)
            source.link_to(used, 0, place)
            sources.append(source)
        used.link_to(output)
        graph.configure()
        return graph, sources

    def _encode_ready(self, graph: Any) -> None:
        """Encode the frames that the filter has ready."""
        with suppress(self._av.error.BlockingIOError, self._av.error.EOFError):
            while True:
                self._encode(graph.pull())


@contextmanager
def video_file(path: str | os.PathLike[str], size: tuple[int, int], fps: int) -> Iterator[VideoFile]:
    """Open a video file that appears under its name only if all went well.

    Whatever is raised, Ctrl-C included, no half-written file is left, and an older file of that name is kept.

    Args:
        path: the file, whose ending is one of FORMATS.
        size: (width, height) [pixels], even numbers for a format that needs them.
        fps: frames a second, from 1 on.

    Raises:
        ConfigError: for an ending that is none of FORMATS; without PyAV, or if its FFmpeg lacks the encoder.
        OutputError: if the file cannot be written.
    """
    path = Path(path)
    kind = format_of(path)
    with unfinished_file(path, ending=path.suffix) as unfinished:
        video = (_GifFile if kind.name == "GIF" else VideoFile)(unfinished, kind, size, fps)
        try:
            yield video
            video.finish()
        except BaseException:
            with suppress(OSError):  # a full disk fails again when its file is closed
                video.close()
            raise


def _pyav(kind: Format) -> Any:
    """Return the module of PyAV, an extra, which some distributions build without an encoder."""
    try:
        import av
    except ImportError:
        raise ConfigError(f"videos need PyAV: {install_hint('video')}") from None
    if kind.encoder not in av.codecs_available:
        raise ConfigError(f"{kind.name} needs PyAV with {kind.encoder}: {install_hint('video')}")
    return av
