"""A contact sheet: a match at some of its instants, side by side in one picture."""

from collections.abc import Sequence
from typing import Final

from catch_arena.errors import ConfigError
from catch_arena.explanation.formatting import seconds
from catch_arena.explanation.highlights import Highlight
from catch_arena.render import hud
from catch_arena.render.encoders import Progress
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.mosaic import fit_grid
from catch_arena.render.raster import Canvas
from catch_arena.render.renderer import MatchRenderer, checked_size, png
from catch_arena.render.shapes import Label, Shape
from catch_arena.render.sprites import SpriteCache
from catch_arena.render.text import printable, text_width
from catch_arena.render.timing import Snapshots
from catch_arena.render.video import checked_view, duration_ms, rendered_frames
from catch_arena.replay import Replay

SIZE: Final = (1600, 1320)
MOST: Final = 100
"""Pictures on one sheet."""
LEAST_SIDE: Final = 72
_STRIP: Final = 0.07
_LINES: Final = 0.085
_LATER_MS: Final = 150
"""So long after a decisive instant its ring is seen well."""
_SAME_MS: Final = 500
"""Pictures that are nearer to each other show the same."""


def even_instants(replay: Replay, count: int) -> list[tuple[float, str]]:
    """So many instants, evenly from the match's beginning to its end."""
    if not 1 <= count <= MOST:
        raise ConfigError(f"count must be from 1 to {MOST}, got {count}")
    whole = duration_ms(replay)
    return [(whole * index / max(1, count - 1), "") for index in range(count)]


def same_picture(one: Highlight, other: Highlight) -> bool:
    """Whether two highlights' pictures would hardly differ; in a video they may not even overlap."""
    return abs(one.decisive_ms - other.decisive_ms) < _SAME_MS


def instants_of(highlights: Sequence[Highlight]) -> list[tuple[float, str]]:
    """Just after the decisive instants, in order, each with what happened."""
    return sorted((float(one.decisive_ms + _LATER_MS), one.what) for one in highlights)


def contact_sheet(
    replay: Replay,
    instants: Sequence[tuple[float, str]],
    *,
    size: tuple[int, int] | None = None,
    view_of: int | str | None = None,
    progress: Progress | None = None,
) -> bytes:
    """A PNG picture of these instants [ms], in order, each with its time and a word about it.

    Args:
        replay: the recorded match.
        instants: when, in milliseconds of the match.
        size: (width, height) from 320 x 320 to 3840 x 2160, or None for as large as the pictures need within SIZE.
        view_of: as of `render.video.render_replay`.
        progress: called with (pictures drawn, in all).

    Raises:
        ConfigError: for a size that no frame has, or that is too small for so many pictures; for a hunter that has no
            view to show.
        ReplayError: where the match does not play as recorded.
    """
    width, height = checked_size(SIZE if size is None else size)
    head = max(30, round(0.045 * height))
    grid = fit_grid(len(instants), (width, height - head), _STRIP + _LINES)
    if size is None:
        width, height = grid.size[0], grid.size[1] + head
    area = hud.Rect(0, head, width, height - head)
    if grid.side < LEAST_SIDE:
        raise ConfigError(
            f"size must give each of {len(instants)} pictures {LEAST_SIDE} pixels at least, got {grid.side}"
        )
    sprites = SpriteCache()
    sheet = Canvas.blank(width, height, hud.PANEL, sprites)
    info = MatchInfo.of_replay(replay)
    sheet.draw(_heading(hud.Rect(0, 0, width, head), info, replay.seed))
    lines = round(_LINES * grid.side)
    renderer = MatchRenderer(info, (grid.side, grid.side + grid.extra - lines), "arena", sprites=sprites)
    if view_of is not None:
        renderer.view_of = checked_view(replay, view_of)
    pictures = rendered_frames(replay, renderer, Snapshots(tuple(time_ms for time_ms, _ in instants)))
    cells = grid.cells(len(instants), area)
    for done, (cell, (time_ms, word), pixels) in enumerate(zip(cells, instants, pictures, strict=True), start=1):
        sheet.pixels[cell.top : cell.top + cell.height - lines, cell.left : cell.left + cell.width] = pixels
        line = cell._replace(top=cell.top + cell.height - lines, height=lines)
        sheet.draw(_stamp(line, time_ms, word))
        if progress is not None:
            progress(done, len(instants))
    return png(sheet.pixels)


def _heading(area: hud.Rect, info: MatchInfo, seed: int) -> list[Shape]:
    """Whose match it is: every hunter's chip and name."""
    size = hud.font_size(0.4 * area.height, 11)
    middle = area.top + 0.56 * area.height
    about = "   ".join(part for part in (info.title, f"seed {seed}") if part)
    right = area.left + area.width - size
    room = right - min(0.33 * area.width, text_width(about, size, 500)) - 2.0 * size
    shapes: list[Shape] = [Label(right, middle, about, size, hud.DIM, 500, "right", max_width=0.33 * area.width)]
    x = float(area.left + size)
    for seat, name in enumerate(info.names):
        wide = hud.chip_width(info, size) + 0.5 * size
        if x + wide + 2.0 * size > room:
            break
        shapes += hud.chip(x, middle, info, seat, size)
        shapes.append(Label(x + wide, middle, name, size, hud.BRIGHT, 600, max_width=room - x - wide))
        x += wide + text_width(name, size, 600) + 1.4 * size
    return shapes


def _stamp(area: hud.Rect, time_ms: float, word: str) -> list[Shape]:
    size = hud.font_size(0.5 * area.height, 9)
    middle = area.top + 0.52 * area.height
    at = seconds(int(time_ms) // 100 * 100)  # tenths that have passed, as on the clock
    beside = text_width(at, size, 700) + 0.8 * size
    room = area.width - 4 - beside
    word_size = size
    while word_size > 9 and text_width(printable(word), word_size, 500) > room:  # its end says by how much
        word_size -= 1
    return [
        Label(area.left + 2, middle, at, size, hud.BRIGHT, 700),
        Label(area.left + 2 + beside, middle, word, word_size, hud.DIM, 500, max_width=room),
    ]
