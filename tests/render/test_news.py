"""The news, without a pixel."""

import pytest
from render.pictured import SIZES, an_info, assert_inside, assert_texts_apart, kinds

from catch_arena.render import hud
from catch_arena.render.marks import Mark, Rival
from catch_arena.render.news import KEPT, News, news_shapes
from catch_arena.render.shapes import Label
from catch_arena.render.text import fitted

CONTEST = Mark("catch", 18_800, 0, 1.0, 1.0, "+1", (Rival(2, 155_000, asked=True),), 143_000)
NEAR_MISS = Mark("catch", 19_000, 1, 1.0, 1.0, "+1", (Rival(0, 455_000, asked=False),), 143_000)


def refused(time_ms: int, seat: int = 3, word: str = "out of reach") -> Mark:
    return Mark("refused", time_ms, seat, 1.0, 1.0, word)


def test_contests_near_misses_and_refusals_are_news_and_undisturbed_catches_are_not():
    news = News()
    news.tell([CONTEST, Mark("catch", 18_900, 1, 1.0, 1.0), NEAR_MISS, refused(19_100)])
    assert [(item.seat, item.text, item.other, item.after) for item in news.items] == [
        (3, "out of reach", None, ""),
        (1, "ahead of", 0, "by 31 cm"),
        (0, "beat", 2, "by 12 mm"),
    ]


def test_a_tie_is_won_by_lot():
    news = News()
    news.tell([Mark("catch", 0, 0, 1.0, 1.0, "+1", (Rival(1, 143_000, asked=True),), 143_000)])
    assert news.items[0].after == "by lot"


def test_a_refusal_that_is_repeated_is_counted_and_moves_up():
    news = News()
    for time_ms in range(0, 1000, 100):
        news.tell([refused(time_ms)])
    news.tell([refused(1000, seat=2), refused(1000, word="already caught"), refused(1100)])
    assert [(item.seat, item.text, item.times) for item in news.items] == [
        (3, "out of reach", 11),
        (3, "already caught", 1),
        (2, "out of reach", 1),
    ]


def test_only_the_latest_are_kept():
    news = News()
    for seat in range(40):
        news.tell([refused(100 * seat, seat)])
    assert [item.seat for item in news.items] == list(range(39, 39 - KEPT, -1))


@pytest.mark.parametrize("hunters", [4, 16])
@pytest.mark.parametrize("size", SIZES)
def test_the_news_fit_their_card(size, hunters):
    plan, info = hud.arrange(size, "broadcast", hunters), an_info(hunters)
    if not plan.news.width:
        return
    news = News()
    assert_inside(news_shapes(plan.news, info, news.items, plan.unit), plan.news)
    news.tell([CONTEST, NEAR_MISS, *(refused(0, word="no such target") for _ in range(5))] * 3)
    shapes = news_shapes(plan.news, info, news.items, plan.unit)
    assert_inside(shapes, plan.news)
    assert_texts_apart(shapes)
    rows = {round(label.y) for label in kinds(shapes, Label)}
    assert len(rows) == min(len(news.items), round((plan.news.height - 16 * plan.unit) / (hud.NEWS_ROW * plan.unit)))
    assert len(rows) >= 2


@pytest.mark.parametrize("size", SIZES)
def test_a_line_about_two_hunters_says_by_how_much_in_full(size):
    plan, info = hud.arrange(size, "broadcast", 4), an_info(4)
    if not plan.news.width:
        return
    news = News()
    news.tell([NEAR_MISS])
    (how,) = (
        label for label in kinds(news_shapes(plan.news, info, news.items, plan.unit), Label) if "by" in label.text
    )
    assert fitted(how.text, how.size, how.weight, how.max_width) == "by 31 cm"
