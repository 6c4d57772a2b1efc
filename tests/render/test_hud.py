"""The panel, without a pixel: everything in its place, at every size and for every number of hunters."""

import itertools

import pytest

from catch_arena.config import ArenaConfig
from catch_arena.render import hud, text
from catch_arena.render.scene import Box, Label, Look, Polygon, Stroke, Turtle

SIZES = [
    (320, 320),
    (321, 480),
    (500, 500),
    (640, 360),
    (720, 1280),
    (960, 720),
    (1280, 720),
    (3840, 2160),
    (3840, 320),
    (320, 2160),
]


def a_look(hunters: int) -> Look:
    names = [f"contested_by_arrival_time_v{seat}" for seat in range(hunters)]
    return Look.of(ArenaConfig(hunters=hunters), names, "Round 3   match 12 of 64", 60_000)


def extent(shape) -> tuple[float, float, float, float]:
    """Left, top, right, bottom."""
    match shape:
        case Box():
            return shape.left, shape.top, shape.left + shape.width, shape.top + shape.height
        case Label():
            shown = text.fitted(shape.text, shape.size, shape.weight, shape.max_width)
            width = text.text_width(shown, shape.size, shape.weight)
            left = shape.x - {"left": 0.0, "center": width / 2, "right": width}[shape.align]
            return left, shape.y - 0.4 * shape.size, left + width, shape.y + 0.4 * shape.size
        case Turtle():
            half = shape.length / 2
            return shape.x - half, shape.y - 0.8 * half, shape.x + half, shape.y + 0.8 * half
        case Polygon():
            x, y = zip(*shape.points, strict=True)
            return min(x), min(y), max(x), max(y)
        case Stroke():
            x, y = (shape.x0, shape.x1), (shape.y0, shape.y1)
            return min(x), min(y), max(x), max(y)
    raise TypeError(shape)


def assert_inside(shapes, area: hud.Rect) -> None:
    for shape in shapes:
        left, top, right, bottom = extent(shape)
        assert left >= area.left - 2, shape
        assert top >= area.top - 2, shape
        assert right <= area.left + area.width + 2, shape
        assert bottom <= area.top + area.height + 2, shape


def assert_texts_apart(shapes) -> None:
    placed = [(shape, extent(shape)) for shape in shapes if isinstance(shape, Label)]
    placed = [(shape, box) for shape, box in placed if box[2] > box[0]]
    for (one, a), (other, b) in itertools.combinations(placed, 2):
        assert a[2] <= b[0] + 0.5 or b[2] <= a[0] + 0.5 or a[3] <= b[1] + 0.5 or b[3] <= a[1] + 0.5, (one, other)


def overlap(a: hud.Rect, b: hud.Rect) -> bool:
    apart = a.left + a.width <= b.left or b.left + b.width <= a.left
    return not (apart or a.top + a.height <= b.top or b.top + b.height <= a.top)


@pytest.mark.parametrize("hunters", [1, 4, 16, 64])
@pytest.mark.parametrize("layout", ["broadcast", "arena"])
@pytest.mark.parametrize("size", SIZES)
def test_the_parts_lie_in_the_frame_and_apart_and_the_arena_is_the_largest(size, layout, hunters):
    plan = hud.arrange(size, layout, hunters)
    parts = [part for part in (plan.arena, plan.header, plan.standings, plan.timeline) if part.width]
    assert len(parts) == (4 if layout == "broadcast" else 2)
    for part in parts:
        assert part.left >= 0
        assert part.top >= 0
        assert part.left + part.width <= size[0]
        assert part.top + part.height <= size[1]
        assert min(part.width, part.height) >= 20
        assert min(part.width, part.height) <= min(plan.arena.width, plan.arena.height)
    assert not any(overlap(a, b) for a, b in itertools.combinations(parts, 2))


@pytest.mark.parametrize("hunters", [1, 2, 4, 8, 16, 33, 64])
@pytest.mark.parametrize("size", SIZES)
def test_the_standings_fit_their_card(size, hunters):
    plan, look = hud.arrange(size, "broadcast", hunters), a_look(hunters)
    standings = [hud.Standing(seat, (seat * 37) % 123, withdrawn=seat == 1) for seat in range(hunters)]
    shapes = hud.standings_shapes(plan.standings, look, standings, plan.unit)
    assert_inside(shapes, plan.standings)
    assert_texts_apart(shapes)
    assert any(label.text == str(max(one.score for one in standings)) for label in shapes if isinstance(label, Label))


@pytest.mark.parametrize("hunters", [1, 2, 4, 8, 64])
@pytest.mark.parametrize("size", SIZES)
def test_the_timeline_fits_its_card(size, hunters):
    plan, look = hud.arrange(size, "broadcast", hunters), a_look(hunters)
    timeline = hud.Timeline(look.duration_ms)
    scores = [0] * hunters
    for time_ms in range(0, 60_000, 700):
        seat = (time_ms // 700) ** 2 % hunters
        scores[seat] += 1
        timeline.tell(time_ms, [seat], scores)
    shapes = hud.timeline_shapes(plan.timeline, look, timeline, 59_990.0, plan.unit)
    assert_inside(shapes, plan.timeline)
    assert_texts_apart(shapes)


@pytest.mark.parametrize("time_text", ["0.0", "59.9", "179.9", "3:00.0", "16666:39.9"])
@pytest.mark.parametrize("size", SIZES)
def test_the_header_fits(size, time_text):
    plan = hud.arrange(size, "broadcast", 4)
    shapes = hud.header_shapes(plan.header, a_look(4), 2**63, time_text, plan.unit)
    assert_inside(shapes, plan.header)
    assert_texts_apart(shapes)


@pytest.mark.parametrize("hunters", [1, 4, 16, 64])
@pytest.mark.parametrize("size", SIZES)
def test_the_line_over_the_arena_fits(size, hunters):
    plan = hud.arrange(size, "arena", hunters)
    chips, clock = hud.split_strip(plan.header, "59.9")
    standings = [hud.Standing(seat, 11 * seat) for seat in range(hunters)]
    shapes = hud.chip_shapes(chips, a_look(hunters), standings)
    assert_inside(shapes, chips)
    assert_texts_apart(shapes)
    assert_inside(hud.strip_clock_shapes(clock, "59.9"), clock)


def test_the_best_stand_first_and_equals_by_seat():
    standings = [hud.Standing(0, 2), hud.Standing(1, 5), hud.Standing(2, 5)]
    assert [one.seat for one in hud.ranked(standings)] == [1, 2, 0]


def test_bars_are_as_long_as_their_part_of_the_leaders_score():
    plan, look = hud.arrange((1280, 720), "broadcast", 2), a_look(2)
    shapes = hud.standings_shapes(plan.standings, look, [hud.Standing(0, 40), hud.Standing(1, 20)], plan.unit)
    full, half = (next(s for s in shapes if isinstance(s, Box) and s.color == look.color(seat)) for seat in (0, 1))
    assert half.width == pytest.approx(full.width / 2)


def test_the_lead():
    assert hud.lead([3, 7, 5]) == (1, 2)
    assert hud.lead([7, 7, 5]) == (-1, 0)
    assert hud.lead([0, 0]) == (-1, 0)
    assert hud.lead([4]) == (0, 4)


def test_the_timeline_keeps_every_hunters_catches_and_the_lead_between_them():
    timeline = hud.Timeline(22_000)  # 100 ms a column
    timeline.tell(0, [], [0, 0])
    timeline.tell(500, [0, 1], [1, 1])
    timeline.tell(550, [1], [1, 2])
    timeline.tell(900, [], [1, 2])
    assert timeline.catches == 3
    assert timeline.catchers[5] == {0, 1}
    assert timeline.leads[4:11] == [(-1, 0), (1, 1), (1, 1), (1, 1), (1, 1), (1, 1), None]


def test_the_timeline_does_not_grow_with_the_match():
    timeline = hud.Timeline(10**9)
    for time_ms in range(0, 10**9, 10**5):
        timeline.tell(time_ms, [0], [time_ms, 0])
    assert len(timeline.catchers) == len(timeline.leads) == hud.COLUMNS


@pytest.mark.parametrize(
    ("time_ms", "shown"), [(0, "0.0"), (99.9, "0.0"), (18_850, "18.8"), (180_000, "3:00.0"), (3_661_500, "61:01.5")]
)
def test_the_clock_shows_tenths_that_have_passed(time_ms, shown):
    assert hud.clock(time_ms) == shown


@pytest.mark.parametrize("duration_s", [0.1, 3.0, 60.0, 61.7, 3600.0, 1e6])
def test_the_axis_has_some_round_times_but_not_too_many(duration_s):
    ticks = hud.tick_seconds(duration_s, 7.0)
    assert 2 <= len(ticks) <= 7
    assert ticks[0] == 0.0
    assert ticks[-1] <= duration_s * (1 + 1e-9)


def test_long_and_odd_names_end_in_an_ellipsis_or_in_spaces():
    shown = text.fitted("a" * 5000, 20, 500, 150.0)
    assert shown.endswith(text.ELLIPSIS)
    assert text.text_width(shown, 20, 500) <= 150
    assert text.fitted("two\nlines\tand\x00more", 20, 500, 1e9) == "two lines and more"
    assert text.fitted("anything", 20, 500, 3.0) == ""
