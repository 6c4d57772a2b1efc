"""Contact sheets."""

import cv2
import numpy as np
import pytest

from catch_arena.errors import ConfigError
from catch_arena.explanation.highlights import Highlight
from catch_arena.render import hud
from catch_arena.render.contact_sheet import _stamp, contact_sheet, even_instants, instants_of
from catch_arena.render.text import truncated
from catch_arena.render.viewport import GROUND


def picture(content: bytes) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR_RGB)


def test_even_instants_reach_from_the_beginning_to_the_end(match):
    assert [time for time, _ in even_instants(match, 4)] == [0, 1000, 2000, 3000]
    assert [time for time, _ in even_instants(match, 1)] == [0]
    with pytest.raises(ConfigError, match="count"):
        even_instants(match, 0)


def test_highlights_are_shown_in_the_order_of_time_with_their_words():
    late, early = (Highlight("lead", 0, at, at + 500, 0.1, f"at {at}", "") for at in (2000, 1000))
    assert instants_of([late, early]) == [(1150.0, "at 1000"), (2150.0, "at 2000")]


@pytest.mark.parametrize("count", [1, 5, 12])
def test_every_picture_is_there(match, count):
    done = []
    sheet = picture(
        contact_sheet(match, even_instants(match, count), size=(900, 700), progress=lambda *at: done.append(at))
    )
    assert sheet.shape == (700, 900, 3)
    assert done == [(k, count) for k in range(1, count + 1)]
    ground = (np.abs(sheet.astype(int) - GROUND).max(axis=2) < 12).astype(np.uint8)
    blocks = cv2.connectedComponentsWithStats(cv2.erode(cv2.dilate(ground, np.ones((9, 9))), np.ones((15, 15))))[2]
    assert (blocks[1:, cv2.CC_STAT_AREA] > 3000).sum() == count


def test_without_a_size_it_is_as_large_as_its_pictures_need(match):
    sheet = picture(contact_sheet(match, even_instants(match, 2)))
    assert sheet.shape[1] > 1.5 * sheet.shape[0]


def test_a_hunters_view_lies_over_each_picture(play):
    foggy = play(time_limit_s=1.0, view_radius_m=2.0)
    plain, seen = (
        picture(contact_sheet(foggy, even_instants(foggy, 3), size=(900, 400), view_of=who)) for who in (None, 1)
    )
    differs = (plain != seen).any(axis=2)
    thirds = np.array_split(differs, 3, axis=1)
    assert all(third.mean() > 0.02 for third in thirds)


def test_where_hunters_see_everything_there_is_no_view_to_show(match):
    with pytest.raises(ConfigError, match="do not see everything"):
        contact_sheet(match, even_instants(match, 1), view_of=0)


def test_pictures_that_would_be_too_small_are_refused(match):
    with pytest.raises(ConfigError, match="72 pixels"):
        contact_sheet(match, even_instants(match, 100), size=(320, 320))


def test_what_is_said_about_a_picture_is_made_smaller_before_it_is_cut_off():
    area = hud.Rect(0, 0, 500, 42)
    *_, word = _stamp(area, 3700.0, "patrol beats contested_by_time by 17 mm")
    assert truncated(word.text, word.size, word.weight, word.max_width) == word.text
    assert word.size < _stamp(area, 3700.0, "a tie")[-1].size


def test_a_picture_says_its_time_as_explain_and_render_take_it():
    """In seconds, also where the clock of a video counts minutes."""
    assert _stamp(hud.Rect(0, 0, 300, 30), 185_249.5, "a tie")[0].text == "185.2 s"
