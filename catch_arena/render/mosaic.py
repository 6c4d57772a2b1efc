"""Video of many matches side by side, all running at the same time."""

import math
import os
from collections.abc import Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Final, NamedTuple

from catch_arena.errors import ConfigError, ReplayError
from catch_arena.render import hud
from catch_arena.render.encoders import Progress, format_of
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.optional_imports import cv2
from catch_arena.render.raster import Canvas, Pixels
from catch_arena.render.renderer import MatchRenderer
from catch_arena.render.shapes import Label
from catch_arena.render.timing import Clip
from catch_arena.render.video import (
    RenderReport,
    frame_size,
    pace_of,
    rendered_frames,
    write_video,
)
from catch_arena.replay import Replay

MOST: Final = 64
"""Greatest number of matches in one picture."""
LARGEST: Final = (1280, 1280)
"""Greatest size of the picture [pixels], which is as large as its cells need."""
LARGEST_SMALL: Final = (720, 720)
"""Greatest size in the formats whose default size is small, GIF and WebP [pixels]."""
MOST_FPS: Final = 30
_STRIP: Final = 0.09
_LABEL: Final = 0.075
_GAP: Final = 0.025
_STAYS_S: Final = 2.0
"""Time for which the last result is seen [s of the video]."""


class Grid(NamedTuple):
    """Layout of the cells: squares in rows and columns, each with extra height for text."""

    columns: int
    rows: int
    side: int
    """Side of a cell's square [pixels]."""
    extra: int
    """Height of a cell besides its square [pixels]."""
    gap: int

    @property
    def size(self) -> tuple[int, int]:
        """Size of all cells with a gap around each: (width, height) [pixels]."""
        return (
            self.columns * (self.side + self.gap) + self.gap,
            self.rows * (self.side + self.extra + self.gap) + self.gap,
        )

    def cells(self, count: int) -> list[hud.Rect]:
        """Return the cells row by row; a last row that is not full is centred."""
        across, down = self.side + self.gap, self.side + self.extra + self.gap
        found = []
        for index in range(count):
            row, column = divmod(index, self.columns)
            short = self.columns - min(self.columns, count - row * self.columns)
            x = self.gap + column * across + short * across // 2
            found.append(hud.Rect(x, self.gap + row * down, self.side, self.side + self.extra))
        return found


def fit_grid(count: int, size: tuple[int, int], extra: float) -> Grid:
    """Return the grid of `count` cells with the largest squares; `extra` is a part of a square's side."""
    width, height = size

    def grid(columns: int) -> Grid:
        rows = -(-count // columns)
        wide = width / (columns + (columns + 1) * _GAP)
        high = height / (rows * (1.0 + extra) + (rows + 1) * _GAP)
        side = int(min(wide, high))
        return Grid(columns, rows, side - side % 2, round(extra * side), max(2, round(_GAP * side)))

    return max(map(grid, range(1, count + 1)), key=lambda candidate: candidate.side)


def render_mosaic(
    replays: Mapping[str, Replay],
    path: str | os.PathLike[str],
    *,
    speed: float = 1.0,
    progress: Progress | None = None,
) -> RenderReport:
    """Write a video in which all matches run at the same time; a match that has ended shows its result until all end.

    A match that does not play as recorded stops at the difference, and its cell says so.

    Args:
        replays: 1 to 64 matches, by the text below each.
        path: the file to write.
        speed: seconds of the match in a second of the video.
        progress: called with (frames written, frames in all).

    Raises:
        ConfigError: for too many matches or none, and an invalid ending or speed.
        OutputError: if the file cannot be written; no half-written file is left.
    """
    if not 1 <= len(replays) <= MOST:
        raise ConfigError(f"a mosaic must have 1 to {MOST} matches, got {len(replays)}")
    kind = format_of(Path(path))
    fps, pace = min(MOST_FPS, kind.fps), pace_of(speed)
    largest = LARGEST if kind.size[0] >= LARGEST[0] else LARGEST_SMALL
    grid = fit_grid(len(replays), largest, _STRIP + _LABEL)
    size = frame_size(kind, grid.size)
    end_ms = max(_end_ms(replay, fps, pace) for replay in replays.values())
    whole = Clip(0, end_ms + round(1000 * _STAYS_S * pace), fps, pace)
    return write_video(path, _pictures(replays, grid, size, whole), size, fps, whole.frames, progress)


def _end_ms(replay: Replay, fps: int, pace: Fraction) -> int:
    """Return an instant late enough for the last frame to show the match's end [ms]."""
    return replay.duration_ms + math.ceil(1000 * pace / fps)


def _pictures(replays: Mapping[str, Replay], grid: Grid, size: tuple[int, int], whole: Clip) -> Iterator[Pixels]:
    frame = Canvas.blank(*size, hud.PANEL)
    cells = []
    for area, (name, replay) in zip(grid.cells(len(replays)), replays.items(), strict=True):
        label = round(_LABEL * area.width)
        picture = area._replace(height=area.height - label)
        renderer = MatchRenderer(MatchInfo.of_replay(replay), picture[2:], "arena")
        clip = Clip(0, _end_ms(replay, whole.fps, whole.speed), whole.fps, whole.speed)
        below = area._replace(top=area.top + area.height - label, height=label)
        cells.append(_Cell(name, renderer, rendered_frames(replay, renderer, clip), frame, picture, below))
    for _ in range(whole.frames):
        for cell in cells:
            cell.advance()
        yield frame.pixels


class _Cell:
    """One match in its part of the picture; the text below names the match and its leader."""

    def __init__(
        self,
        name: str,
        renderer: MatchRenderer,
        frames: Iterator[Pixels],
        frame: Canvas,
        picture: hud.Rect,
        label: hud.Rect,
    ) -> None:
        self._name, self._renderer, self._frames = name, renderer, frames
        self._frame, self._picture, self._label = frame, frame.part(picture), label
        self._running = True
        self._write(None)
        self._leader: int | None = None

    def advance(self) -> None:
        """Draw the next frame, or the result if the match has ended."""
        if not self._running:
            return
        try:
            pixels = next(self._frames, None)
        except ReplayError:
            self._end("replay differs", None)
            return
        leader, contenders = self._renderer.leader, self._renderer.info.contenders
        if pixels is None:
            self._end("a tie" if leader is None else f"{contenders[leader].name} wins", leader)
            return
        self._picture.pixels[:] = pixels
        if leader != self._leader:
            self._leader = leader
            self._write(leader)

    def _end(self, text: str, contender: int | None) -> None:
        """Darken the last picture and write the result on it."""
        self._running = False
        arena = self._picture.part(self._renderer.arena)
        height, width = arena.pixels.shape[:2]
        arena.pixels[:] = cv2.convertScaleAbs(arena.pixels, alpha=0.45)
        size = hud.font_size(0.085 * width, 11)
        color = hud.BRIGHT if contender is None else hud.legible(self._renderer.info.contenders[contender].color)
        middle = (0.5 * width, 0.5 * height)
        arena.draw([Label(*middle, text, size, color, 800, "center", outline=hud.PANEL, max_width=0.94 * width)])

    def _write(self, leader: int | None) -> None:
        area = self._label
        size = hud.font_size(0.58 * area.height, 9)
        middle = area.top + 0.5 * area.height
        self._frame.clear(area, hud.PANEL)
        self._frame.draw([Label(area.left + 2, middle, self._name, size, hud.DIM, 500, max_width=0.52 * area.width)])
        if leader is not None:
            contender, right = self._renderer.info.contenders[leader], area.left + area.width - 2
            color, room = hud.legible(contender.color), 0.44 * area.width
            self._frame.draw([Label(right, middle, contender.name, size, color, 700, "right", max_width=room)])
