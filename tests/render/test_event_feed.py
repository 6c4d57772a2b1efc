"""The event feed lists contests, near misses and refusals, and fits its card."""

from dataclasses import replace

import pytest
from render.pictured import SIZES, an_info, assert_inside, assert_texts_apart, kinds

from catch_arena.explanation.facts import Claim, Contest
from catch_arena.render import hud
from catch_arena.render.annotations import Annotation, Neighbour
from catch_arena.render.event_feed import feed_shapes, with_items
from catch_arena.render.shapes import Label
from catch_arena.verdicts import Verdict


def contest(distance_um: int, clause: str = "R5.4") -> Contest:
    """A contest in which hunter 0, 143 mm away, wins against hunter 2."""
    claims = Claim(0, Verdict.GRANTED, 143_000), Claim(2, Verdict.LOST_CONTEST, distance_um)
    return Contest(189, 18_800, "target_turtle_7", clause, claims)


CONTEST = Annotation("catch", 18_800, 0, 1.0, 1.0, "+1", contest(155_000))
NEAR_MISS = Annotation("catch", 19_000, 1, 1.0, 1.0, "+1", None, (Neighbour(0, 312_000),))


def refused(time_ms: int, seat: int = 3, word: str = "out of reach") -> Annotation:
    return Annotation("refused", time_ms, seat, 1.0, 1.0, word)


def test_contests_near_misses_and_refusals_are_in_the_feed_and_undisturbed_catches_are_not():
    feed = with_items((), [CONTEST, Annotation("catch", 18_900, 1, 1.0, 1.0), NEAR_MISS, refused(19_100)])
    assert [item.parts for item in feed] == [
        (3, "out of reach"),
        (1, "ahead of", 0, "by 312 mm"),
        (0, "beat", 2, "by 12 mm"),
    ]


def test_a_tie_is_won_by_lot():
    tie = replace(CONTEST, contest=contest(143_000, "R5.5"))
    assert with_items((), [tie])[0].parts == (0, "beat", 2, "by lot")


def test_a_contest_that_the_queue_decides_is_won_by_lot_whoever_was_nearer():
    """R5.9: distance decides nothing there, and the captions and the lens say so too."""
    feed = with_items((), [replace(CONTEST, contest=contest(155_000, "R5.9")), NEAR_MISS])
    assert [item.parts for item in feed] == [(1, "ahead of", 0, "by 312 mm"), (0, "beat", 2, "by lot")]


def test_a_refusal_that_is_repeated_is_counted_and_moves_up():
    feed = ()
    for time_ms in range(0, 1000, 100):
        feed = with_items(feed, [refused(time_ms)])
    feed = with_items(feed, [refused(1000, seat=2), refused(1000, word="already caught"), refused(1100)])
    assert [(*item.parts, item.times) for item in feed] == [
        (3, "out of reach", 11),
        (3, "already caught", 1),
        (2, "out of reach", 1),
    ]


@pytest.mark.parametrize("hunters", [4, 16])
@pytest.mark.parametrize("size", SIZES)
def test_the_feed_fits_its_card(size, hunters):
    plan, info = hud.arrange(size, "broadcast", hunters), an_info(hunters)
    if not plan.feed.width:
        return
    assert_inside(feed_shapes(plan.feed, info, (), plan.unit), plan.feed)
    feed = with_items((), [CONTEST, NEAR_MISS, *(refused(0, word="waiting for partner") for _ in range(5))] * 3)
    shapes = feed_shapes(plan.feed, info, feed, plan.unit)
    assert_inside(shapes, plan.feed)
    assert_texts_apart(shapes)
    rows = {round(label.y) for label in kinds(shapes, Label)}
    assert len(rows) == min(len(feed), round((plan.feed.height - 16 * plan.unit) / (hud.FEED_ROW * plan.unit)))
    assert len(rows) >= 2


def test_a_catch_of_prey_is_in_the_feed_whoever_was_near():
    """With its number, above the contest that it was won in."""
    feed = with_items((), [Annotation("catch", 0, 1, 1.0, 1.0, prey=5), replace(CONTEST, prey=4)])
    assert [item.parts for item in feed] == [
        (0, "caught", 4),
        (0, "beat", 2, "by 12 mm"),
        (1, "caught", 5),
    ]
