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
from catch_arena.render.match_info import Contender
from catch_arena.render.optional_imports import cv2
from catch_arena.render.raster import Canvas, Pixels
from catch_arena.render.shapes import Label, Shape
from catch_arena.render.timing import Clip
from catch_arena.render.video import RenderReport, VideoOutput, pace_of, rendered_frames, renderer_for
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

    A match that does not play as recorded stops at the difference, and its cell says so. There may be 1 to MOST
    matches, by the text below each. The other arguments are those of `video.render_replay`, and so are
    all errors but ReplayError.
    """
    if not 1 <= len(replays) <= MOST:
        raise ConfigError(f"a mosaic must have 1 to {MOST} matches, got {len(replays)}")
    kind = format_of(Path(path))
    fps, pace = min(MOST_FPS, kind.fps), pace_of(speed)
    largest = LARGEST if kind.size[0] >= LARGEST[0] else LARGEST_SMALL
    grid = fit_grid(len(replays), largest, _STRIP + _LABEL)
    output = VideoOutput.of(path, grid.size, fps=fps)
    end_ms = max(_end_ms(replay, fps, pace) for replay in replays.values())
    whole = Clip(0, end_ms + round(1000 * _STAYS_S * pace), fps, pace)
    return output.write(_pictures(replays, grid, output.size, whole), whole.frames, progress)


def _end_ms(replay: Replay, fps: int, pace: Fraction) -> int:
    """Return an instant late enough for the last frame to show the match's end [ms]."""
    return replay.duration_ms + math.ceil(1000 * pace / fps)


def _pictures(replays: Mapping[str, Replay], grid: Grid, size: tuple[int, int], whole: Clip) -> Iterator[Pixels]:
    frame = Canvas.blank(*size, hud.PANEL)
    areas = grid.cells(len(replays))
    cells = [_play(*match, frame, area, whole) for match, area in zip(replays.items(), areas, strict=True)]
    for _ in range(whole.frames):
        for cell in cells:
            next(cell, None)
        yield frame.pixels


def _play(name: str, replay: Replay, frame: Canvas, area: hud.Rect, whole: Clip) -> Iterator[None]:
    """Draw a match into its cell, frame by frame, and at last its result; the text below names match and leader."""
    height = round(_LABEL * area.width)
    cell = area._replace(height=area.height - height)
    below = area._replace(top=cell.top + cell.height, height=height)
    picture = frame.part(cell)
    renderer = renderer_for(replay, cell[2:], "arena")
    contenders = renderer.info.contenders
    leader: int | None = None
    frame.draw(_label_shapes(below, name, None))
    clip = Clip(0, _end_ms(replay, whole.fps, whole.speed), whole.fps, whole.speed)
    try:
        for pixels in rendered_frames(replay, renderer, clip):
            picture.pixels[:] = pixels
            if renderer.leader != leader:
                leader = renderer.leader
                frame.clear(below, hud.PANEL)
                frame.draw(_label_shapes(below, name, None if leader is None else contenders[leader]))
            yield
        result = "a tie" if leader is None else f"{contenders[leader].name} wins"
    except ReplayError:
        result, leader = "replay differs", None
    color = hud.BRIGHT if leader is None else hud.legible(contenders[leader].color)
    arena = picture.part(renderer.arena)
    arena.pixels[:] = cv2.convertScaleAbs(arena.pixels, alpha=0.45)
    _, _, wide, high = renderer.arena
    size = hud.font_size(0.085 * wide, 11)
    middle = (0.5 * wide, 0.5 * high)
    arena.draw([Label(*middle, result, size, color, 800, "center", outline=hud.PANEL, max_width=0.94 * wide)])


def _label_shapes(area: hud.Rect, name: str, leader: Contender | None) -> list[Shape]:
    """Return the text below a cell: the match's name at the left, and its leader at the right."""
    size, middle = hud.font_size(0.58 * area.height, 9), area.top + 0.5 * area.height
    shapes: list[Shape] = [Label(area.left + 2, middle, name, size, hud.DIM, 500, max_width=0.52 * area.width)]
    if leader is not None:
        right, color, room = area.left + area.width - 2, hud.legible(leader.color), 0.44 * area.width
        shapes.append(Label(right, middle, leader.name, size, color, 700, "right", max_width=room))
    return shapes
