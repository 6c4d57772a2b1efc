"""What stands around the arena: who leads, how it came about, and the clock.

Pure functions from small states to shapes.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Literal, NamedTuple

from catch_arena.render.scene import WHITE, Box, Color, Label, Look, Polygon, Shape, Stroke, Turtle, mix

Layout = Literal["broadcast", "arena"]
"""With a panel of standings and a timeline beside the arena, or with one line over it."""

PANEL: Final[Color] = (12, 16, 42)
CARD: Final[Color] = (22, 29, 64)
TRACK: Final[Color] = (40, 47, 86)
DIM: Final[Color] = (150, 158, 204)
BRIGHT: Final[Color] = (240, 243, 255)

COLUMNS: Final = 220
"""Of the timeline: however long the match, it is kept and drawn in so many parts."""


ROW: Final = 58.0
"""The most that a line of the standings takes, in units."""


class Rect(NamedTuple):
    """Whole pixels."""

    left: int
    top: int
    width: int
    height: int


@dataclass(frozen=True, slots=True)
class Arrangement:
    """Where everything stands in a frame; what has no area is left out."""

    arena: Rect
    header: Rect
    standings: Rect
    timeline: Rect
    unit: float
    """Pixels of the frame for a pixel of a 1280 x 720 one: texts and gaps follow it."""


class Standing(NamedTuple):
    """One hunter's line."""

    seat: int
    score: int
    withdrawn: bool = False


@dataclass(slots=True)
class Timeline:
    """Who caught when, and who led by how much: two values for each of COLUMNS parts of the match."""

    duration_ms: int
    catches: int = 0
    catchers: list[frozenset[int]] = field(default_factory=lambda: [frozenset()] * COLUMNS)
    """The seats that caught in each part."""
    leads: list[tuple[int, int] | None] = field(default_factory=lambda: [None] * COLUMNS)
    """(seat, catches ahead of the next) at the end of each part; seat -1 where nobody is; None for the future."""
    _reached: int = -1

    def column(self, time_ms: float) -> int:
        """The part of the match that an instant falls into."""
        return min(COLUMNS - 1, max(0, int(time_ms * COLUMNS / max(1, self.duration_ms))))

    def tell(self, time_ms: float, catchers: Sequence[int], scores: Sequence[int]) -> None:
        """Advance to an instant at which those hunters caught and these are the scores."""
        column = self.column(time_ms)
        for part in range(self._reached + 1, column):  # nothing happened in between
            self.leads[part] = self.leads[self._reached] if self._reached >= 0 else (-1, 0)
        self._reached = column
        self.leads[column] = lead(scores)
        self.catchers[column] |= frozenset(catchers)
        self.catches += len(catchers)


def lead(scores: Sequence[int]) -> tuple[int, int]:
    """The leader's seat and how far behind the next is; (-1, 0) where they are level. One alone leads by its score."""
    best = max(scores)
    if list(scores).count(best) > 1 or best == 0:
        return -1, 0
    return list(scores).index(best), best - max((score for score in scores if score != best), default=0)


def arrange(size: tuple[int, int], layout: Layout, hunters: int) -> Arrangement:
    """Where everything stands in a frame: the panel at the right of a wide one, below in a tall one, else around."""
    width, height = size
    nothing = Rect(0, 0, 0, 0)
    if layout == "arena":
        strip = max(22, round(0.056 * min(width, height)))
        arena = Rect(0, strip, width, height - strip)
        return Arrangement(arena, Rect(0, 0, width, strip), nothing, nothing, strip / 40.0)
    if width >= 1.25 * height:
        side = min(height, round(0.64 * width))
        unit = min(height / 720.0, (width - side) / 560.0)
        gap = round(20 * unit)
        header, standings, timeline = _cards(
            Rect(side + gap, gap, width - side - 2 * gap, height - 2 * gap), unit, hunters
        )
        return Arrangement(Rect(0, 0, side, height), header, standings, timeline, unit)
    if height >= 1.25 * width:
        unit = max(0.6, min(width / 560.0, height / 1160.0))
        gap = round(16 * unit)
        top = round(56 * unit) + gap
        arena_height = min(width, height - top - round(200 * unit))
        below = top + arena_height + gap
        rest = Rect(gap, below, width - 2 * gap, height - below - gap)
        _, standings, timeline = _cards(rest, unit, hunters, header=False)
        return Arrangement(
            Rect(0, top, width, arena_height),
            Rect(gap, gap // 2, width - 2 * gap, top - gap),
            standings,
            timeline,
            unit,
        )
    unit = max(0.55, min(width, height) / 800.0)
    gap = round(14 * unit)
    top, bottom = round(56 * unit) + gap, round(max(0.2 * height, 84.0))
    arena_width = min(round(0.66 * width), round(1.1 * (height - top - bottom)))
    arena = Rect(0, top, arena_width, height - top - bottom)
    return Arrangement(
        arena,
        Rect(gap, gap // 2, width - 2 * gap, top - gap),
        Rect(arena_width + gap, top, width - arena_width - 2 * gap, arena.height),
        Rect(gap, height - bottom + gap, width - 2 * gap, bottom - 2 * gap),
        unit,
    )


def _cards(panel: Rect, unit: float, hunters: int, *, header: bool = True) -> tuple[Rect, Rect, Rect]:
    """Header, standings and timeline in a panel: one below the other, or the last two side by side in a wide one."""
    gap = round(14 * unit)
    top = round(48 * unit) + gap if header else 0
    head = Rect(panel.left, panel.top, panel.width, top - gap if header else 0)
    rest = Rect(panel.left, panel.top + top, panel.width, panel.height - top)
    if rest.width > 1.6 * rest.height:
        half = (rest.width - gap) // 2
        left = Rect(rest.left, rest.top, half, rest.height)
        return head, left, Rect(rest.left + half + gap, rest.top, rest.width - half - gap, rest.height)
    wanted = round(hunters * ROW * unit + 16 * unit)
    below = max(rest.height - gap - wanted, min(round(0.36 * rest.height), round(190 * unit)))
    standings = Rect(rest.left, rest.top, rest.width, rest.height - below - gap)
    return head, standings, Rect(rest.left, rest.top + rest.height - below, rest.width, below)


def clock(time_ms: float) -> str:
    """The match's time as it is shown: tenths of a second that have passed in full, minutes from three minutes on."""
    tenths = int(time_ms) // 100
    if tenths < 1800:
        return f"{tenths / 10:.1f}"
    return f"{tenths // 600}:{tenths % 600 / 10:04.1f}"


def ranked(standings: Sequence[Standing]) -> list[Standing]:
    """The best first; equal scores in the order of seats."""
    return sorted(standings, key=lambda one: (-one.score, one.seat))


def header_shapes(area: Rect, look: Look, seed: int | None, time_text: str, unit: float) -> list[Shape]:
    """The title, what match this is, and the clock."""
    big, small = _size(34 * unit, 15), _size(15 * unit, 10)
    right = area.left + area.width
    about = "   ".join(part for part in (look.title, "" if seed is None else f"seed {seed}") if part)
    clock_room = len(time_text) * 0.68 * big + 1.6 * small
    middle = area.top + area.height * (0.36 if about else 0.5)
    shapes: list[Shape] = [
        Label(
            area.left, middle, "CATCH ARENA", _size(28 * unit, 13), BRIGHT, 700, max_width=area.width - clock_room - 8
        ),
        Label(right - 1.2 * small, middle, time_text, big, BRIGHT, 700, "right"),
        Label(right, middle + 0.36 * (big - small), "s" if ":" not in time_text else "", small, DIM, 500, "right"),
    ]
    if about:
        shapes.append(
            Label(
                area.left, area.top + area.height * 0.86, about, small, DIM, 500, max_width=area.width - clock_room - 8
            )
        )
    return shapes


def split_strip(area: Rect, time_text: str) -> tuple[Rect, Rect]:
    """The line over the arena: the part for the scores, and the clock's at its right end."""
    room = round((len(time_text) + 1.5) * 0.62 * _size(0.58 * area.height, 12))
    return area._replace(width=area.width - room), area._replace(left=area.left + area.width - room, width=room)


def strip_clock_shapes(area: Rect, time_text: str) -> list[Shape]:
    """The clock in the line over the arena."""
    size = _size(0.58 * area.height, 12)
    return [
        Label(area.left + area.width - 0.5 * size, area.top + area.height / 2.0, time_text, size, BRIGHT, 700, "right")
    ]


def chip_shapes(area: Rect, look: Look, standings: Sequence[Standing]) -> list[Shape]:
    """Every hunter's number on its colour, and its score: by seat, or the best as far as there is room."""
    size = _size(0.58 * area.height, 12)
    middle = area.top + area.height / 2.0
    number_width = 0.6 * len(str(len(standings) - 1)) * size
    step = number_width + (1.6 + 0.66 * max(len(str(one.score)) for one in standings)) * size
    fits = max(1, int((area.width - 0.5 * size) // step))
    shown = sorted(standings) if fits >= len(standings) else ranked(standings)[:fits]
    shapes: list[Shape] = []
    x = area.left + 0.5 * size
    for one in shown:
        color = mix(look.color(one.seat), PANEL, 0.6 if one.withdrawn else 0.0)
        chip = number_width + 0.7 * size
        shapes += [
            Box(x, middle - 0.56 * size, chip, 1.12 * size, color, 0.3 * size),
            Label(x + chip / 2.0, middle, str(one.seat), _size(0.82 * size, 9), readable_on(color), 800, "center"),
            Label(x + chip + 0.25 * size, middle, str(one.score), size, BRIGHT, 700),
        ]
        x += step
    return shapes


def standings_shapes(area: Rect, look: Look, standings: Sequence[Standing], unit: float) -> list[Shape]:
    """A line for each hunter, the best first: turtle, number, name, its share of the leader's score, and the score."""
    pad = 8 * unit
    lines = ranked(standings)
    best = max(1, lines[0].score)
    room = area.height - 2.0 * pad
    least = max(15.0, 19.0 * unit)
    rows = max(1, int(room // least))
    columns = (
        1 if len(lines) <= rows else max(1, min(-(-len(lines) // rows), int(area.width // max(130.0, 165.0 * unit))))
    )
    left_out = len(lines) - rows * columns
    if left_out > 0:  # the last line says how many more there are
        left_out += 1
        lines = lines[: rows * columns - 1]
    per_column = -(-(len(lines) + (left_out > 0)) // columns)
    height = min(room / per_column, max(28.0, ROW * unit))
    width = (area.width - 2.0 * pad) / columns
    shapes: list[Shape] = [Box(area.left, area.top, area.width, per_column * height + 2.0 * pad, CARD, 12 * unit)]
    for place, one in enumerate(lines):
        column, row = divmod(place, per_column)
        line = (area.left + pad + column * width, area.top + pad + row * height, width, height)
        shapes += _line(line, look, one, best, unit)
    if left_out > 0:
        column, row = divmod(len(lines), per_column)
        x, y = area.left + pad + column * width, area.top + pad + (row + 0.5) * height
        shapes.append(Label(x + 0.3 * height, y, f"and {left_out} more", _size(0.5 * height, 10), DIM, 500))
    return shapes


def _line(line: tuple[float, float, float, float], look: Look, one: Standing, best: int, unit: float) -> list[Shape]:
    left, top, width, height = line
    middle = top + height / 2.0
    size = min(_size(0.54 * height, 10), _size(21 * unit, 11), _size(0.1 * width, 9))
    color = look.color(one.seat)
    digits = len(str(best))
    x = left + 0.3 * size
    shapes: list[Shape] = [Turtle(x + 0.85 * size, middle, 0.0, 1.75 * size, color, faded=one.withdrawn)]
    x += 2.1 * size
    number_size = _size(0.8 * size, 9)
    number_room = 0.62 * number_size * len(str(len(look.names) - 1))
    shapes.append(Label(x + number_room, middle, str(one.seat), number_size, DIM, 600, "right"))
    x += number_room + 0.6 * size
    right = left + width - 0.5 * size
    bar_end = right - (0.78 * digits + 0.6) * size
    has_bar = width >= 21 * size
    bar_start = max(x + 4.5 * size, bar_end - 0.3 * width) if has_bar else bar_end
    name = look.names[one.seat] + ("  (out)" if one.withdrawn else "")
    shapes.append(
        Label(x, middle, name, size, DIM if one.withdrawn else BRIGHT, 500, max_width=bar_start - x - 0.5 * size)
    )
    shapes.append(Label(right, middle, str(one.score), _size(1.1 * size, 11), BRIGHT, 800, "right"))
    if has_bar:
        thick = max(3.0, 0.48 * size)
        length = bar_end - bar_start
        shapes.append(Box(bar_start, middle - thick / 2, length, thick, TRACK, thick / 2))
        if one.score:
            filled = max(thick, length * one.score / best)
            shapes.append(
                Box(bar_start, middle - thick / 2, filled, thick, mix(color, CARD, 0.5 * one.withdrawn), thick / 2)
            )
    return shapes


def cursor_x(area: Rect, timeline: Timeline, time_ms: float, unit: float) -> float:
    """Where the present is on the timeline [pixels]."""
    left, width = _chart(area, unit)
    return left + width * min(1.0, time_ms / max(1, timeline.duration_ms))


def _chart(area: Rect, unit: float) -> tuple[float, float]:
    pad = 16 * unit
    axis = 2.6 * _size(12 * unit, 9)
    return area.left + pad + axis, area.width - 2 * pad - axis


def timeline_shapes(area: Rect, look: Look, timeline: Timeline, time_ms: float, unit: float) -> list[Shape]:
    """Catches as ticks in their hunters' colours; below, how far ahead of the next the leader was, in the leader's."""
    shapes: list[Shape] = [Box(*area, CARD, 12 * unit)]
    text, small = _size(14 * unit, 10), _size(12 * unit, 9)
    pad = 16 * unit
    left, width = _chart(area, unit)
    right = left + width
    alone = len(look.names) == 1
    many = "1 catch" if timeline.catches == 1 else f"{timeline.catches} catches"
    head = area.top + max(0.95 * text, min(0.11 * area.height, 22 * unit))
    many_room = 0.6 * text * len(many)
    shapes += [
        Label(
            area.left + pad,
            head,
            "Catches" if alone else "Catches and lead",
            text,
            DIM,
            500,
            max_width=area.width - 2 * pad - many_room,
        ),
        Label(right, head, many, text, DIM, 500, "right"),
    ]
    foot = area.top + area.height - max(0.85 * small, min(0.08 * area.height, 18 * unit))
    lane_top = head + 0.95 * text
    base = foot - 1.15 * small
    lanes = len(look.names) if (base - lane_top) / 2.0 >= 1.25 * small * len(look.names) else 1
    pitch = min(20.0 * unit, 0.5 * (base - lane_top) / lanes)
    lane = max(4.0, min(12.0 * unit, 0.7 * pitch))
    step = width / COLUMNS
    for row in range(lanes):
        row_top = lane_top + row * pitch
        shapes.append(Box(left, row_top, width, lane, TRACK, lane / 2))
        if lanes > 1:
            shapes.append(Label(left - 0.5 * small, row_top + lane / 2, str(row), small, look.color(row), 700, "right"))
    tick = max(step, min(3.0 * unit, 3.0), 1.5)
    for part, seats in enumerate(timeline.catchers):
        for seat in sorted(seats):
            row_top = lane_top + (seat * pitch if lanes > 1 else 0.0)
            shapes.append(Box(left + (part + 0.5) * step - tick / 2, row_top, tick, lane, look.color(seat)))
    top = lane_top + (lanes - 1) * pitch + lane + max(4.0, 0.05 * area.height)
    most = max((ahead for _, ahead in (now or (-1, 0) for now in timeline.leads)), default=0)
    height = base - top
    now_x = cursor_x(area, timeline, time_ms, unit)
    if height >= 8:
        scale = height / max(3, most)
        for start, end, seat, ahead in _runs(timeline):
            x0, x1 = left + start * step, min(left + end * step, max(now_x, left + start * step + 1.0))
            y = base - ahead * scale
            color = look.color(seat)
            shapes.append(Polygon(((x0, base), (x0, y), (x1, y), (x1, base)), mix(color, CARD, 0.55)))
            shapes.append(Stroke(x0, y, x1, y, max(1.0, 2.0 * unit), color))
        shapes.append(Label(left - 0.5 * small, top + 0.4 * small, f"+{max(3, most)}", small, DIM, 600, "right"))
        shapes.append(Stroke(left, base, right, base, 1.0, mix(CARD, DIM, 0.4)))
    for at_s in tick_seconds(timeline.duration_ms / 1000.0, width / (5.2 * small)):
        x = left + width * 1000.0 * at_s / max(1, timeline.duration_ms)
        shapes.append(Label(min(x, right - 1.2 * small), foot, axis_time(at_s), small, DIM, 500, "center"))
    shapes.append(Stroke(now_x, lane_top - 2.0, now_x, base, max(1.0, 1.6 * unit), WHITE))
    return shapes


def _runs(timeline: Timeline) -> list[tuple[int, int, int, int]]:
    """(first column, last + 1, seat, catches ahead) of every stretch in which the same one led by the same."""
    runs: list[tuple[int, int, int, int]] = []
    for part, now in enumerate(timeline.leads):
        if now is None or now[0] < 0:
            continue
        if runs and runs[-1][1] == part and runs[-1][2:] == now:
            runs[-1] = (runs[-1][0], part + 1, *now)
        else:
            runs.append((part, part + 1, *now))
    return runs


def tick_seconds(duration_s: float, most: float) -> list[float]:
    """Round times from 0 to the end, at most so many."""
    for step in (step * 10.0**power for power in range(-1, 8) for step in (1.0, 2.0, 3.0, 6.0)):
        if duration_s / step + 1 <= max(2.0, most):
            return [step * count for count in range(math.floor(duration_s / step + 1e-9) + 1)]
    return [0.0]


def axis_time(at_s: float) -> str:
    """A round time, as the timeline's axis says it."""
    return f"{at_s:g} s" if at_s < 600 else f"{at_s / 60:.0f} min"


def readable_on(color: Color) -> Color:
    """Dark or bright, whichever stands out from that colour."""
    luminance = 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]
    return PANEL if luminance > 120 else BRIGHT


def _size(pixels: float, least: int) -> int:
    return max(least, round(pixels))
