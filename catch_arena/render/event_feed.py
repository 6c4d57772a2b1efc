"""The event feed: the latest contests, near misses and refusals in words, the newest first.

Pure functions from small states to shapes.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Final, Literal

from catch_arena.explanation.formatting import millimetres
from catch_arena.explanation.sentences import margin_phrase
from catch_arena.render.annotations import Annotation
from catch_arena.render.hud import BRIGHT, CARD, DIM, FEED_ROW, Rect, agent_chip, chip_width, clock, font_size
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import Box, Label, Shape
from catch_arena.render.text import text_width

_LEAST_TIMED: Final = 21.0
"""Least width of a card with times, in sizes of its text."""
MOST_ITEMS: Final = 8
"""Greatest number of items that are kept; a card shows those that fit."""


@dataclass(frozen=True, slots=True)
class FeedItem:
    """One line of the feed."""

    time_ms: int
    parts: tuple[int | str, ...]
    """Agents and words, in the order of the line."""
    kind: Literal["contest", "near", "refused"]
    times: int = 1


def feed_items(annotation: Annotation) -> Iterator[FeedItem]:
    """Yield the items of a refusal, of a catch with a rival near, and of a catch of prey."""
    time_ms, seat, contest = annotation.time_ms, annotation.seat, annotation.contest
    if annotation.kind == "refused":
        yield FeedItem(time_ms, (seat, annotation.text), "refused")
    if contest is not None:
        yield FeedItem(time_ms, (seat, "beat", contest.claims[1].seat, margin_phrase(contest)), "contest")
    elif annotation.neighbours:
        rival, behind_um = annotation.neighbours[0]
        if behind_um is not None and behind_um > 0:
            yield FeedItem(time_ms, (seat, "ahead of", rival, f"by {millimetres(behind_um)}"), "near")
    if annotation.prey is not None:
        yield FeedItem(time_ms, (seat, "caught", annotation.prey), "contest")


def with_items(feed: Sequence[FeedItem], annotations: Iterable[Annotation]) -> tuple[FeedItem, ...]:
    """Return the feed, the newest item first, with the items of the latest annotations.

    Refusals of the same hunter for the same reason are one item with a count.
    """
    for item in chain.from_iterable(map(feed_items, annotations)):
        same = [old for old in feed if item.kind == "refused" and old.parts == item.parts]
        counted = replace(item, times=item.times + sum(old.times for old in same))
        feed = [counted, *(old for old in feed if old not in same)][:MOST_ITEMS]
    return tuple(feed)


def feed_shapes(area: Rect, info: MatchInfo, items: Sequence[FeedItem], unit: float) -> list[Shape]:
    """Return the shapes of the feed's card, with as many items as fit."""
    pad = 8 * unit
    height = FEED_ROW * unit
    size = font_size(14 * unit, 10)
    shapes: list[Shape] = [Box(*area, CARD, 12 * unit)]
    left = area.left + 2.0 * pad
    timed = area.width >= _LEAST_TIMED * size  # a narrow card shows the margin of a contest and not its time
    if not items:
        position = (left, area.top + pad + 0.5 * height)
        shapes.append(Label(*position, "Contests and refusals", size, DIM, 500, max_width=area.width - 4.0 * pad))
    for row, item in enumerate(items[: max(1, round((area.height - 2.0 * pad) / height))]):
        middle = area.top + pad + (row + 0.5) * height
        x = left
        if timed:
            shapes.append(Label(x + 3.2 * size, middle, clock(item.time_ms), size, DIM, 500, "right"))
            x += 4.0 * size
        color, weight = (BRIGHT, 700) if item.kind == "contest" else (DIM, 500)
        for part in item.parts:
            if isinstance(part, int):
                shapes += agent_chip(x, middle, info, part, size)
                x += chip_width(info, size) + 0.6 * size
                continue
            words = part if item.times == 1 else f"{part}  × {item.times}"
            room = area.left + area.width - 2.0 * pad - x
            shapes.append(Label(x, middle, words, size, color, weight, max_width=room))
            x += text_width(words, size, weight) + 0.6 * size
    return shapes
