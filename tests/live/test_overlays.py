"""The key card lists every key, and the verdict names the winner."""

import pytest

from catch_arena.config import ArenaConfig
from catch_arena.live import overlays
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import Box, Label
from catch_arena.render.viewport import Viewport
from catch_arena.tournament.parties import Parties

AREAS = [(320, 240), (720, 720), (2160, 2160)]
INFO = MatchInfo.of(ArenaConfig(), ("you", "nearest", "patrol", "a name that is longer than any card is wide " * 3))


def within(shapes, area) -> bool:
    boxes = [shape for shape in shapes if isinstance(shape, Box)]
    labels = [shape for shape in shapes if isinstance(shape, Label)]
    return all(
        box.left >= 0 and box.top >= 0 and box.left + box.width <= area[0] and box.top + box.height <= area[1]
        for box in boxes
    ) and all(0 <= label.x <= area[0] and 0 <= label.y <= area[1] for label in labels)


@pytest.mark.parametrize("area", AREAS)
def test_every_key_is_on_the_card(area):
    rows = (*overlays.DRIVING, *overlays.WINDOW)
    shapes = overlays.keys_overlay(Viewport(*area, 11.0), rows, "press any key to begin")
    texts = [shape.text for shape in shapes if isinstance(shape, Label)]
    assert {meaning for _, meaning in rows} <= set(texts)
    assert {"W", "A", "S", "D", "space", "P", "N", ".", "R", "Ctrl-S", "H", "Esc"} <= set(texts)
    caps = [cap for names, _ in rows for cap in names]
    assert len(set(caps)) == len(caps)  # one key, one meaning
    assert within(shapes, area)


def verdict(info, ranks, scores) -> str:
    return overlays.verdict(info, Parties.of(info.config), ranks, scores)


def test_the_winner_is_named_a_first_rank_may_be_shared_and_ones_own_win_is_told():
    assert verdict(INFO, (4, 2, 1, 2), (0, 7, 9, 7)) == "patrol wins"
    assert verdict(INFO, (1, 1, 3, 3), (7, 7, 0, 0)) == "2 share the first rank"
    assert verdict(INFO, (1, 2, 3, 4), (7, 2, 1, 0)) == "You win"


def test_a_team_wins_together_and_prey_is_told_how_often_it_was_caught():
    info = MatchInfo.of(ArenaConfig(teams=((0, 1), (2, 3)), prey=1), ("you", "nearest", "patrol", "patrol", "flee"))
    assert verdict(info, (1, 2, 1), (9, 7, 3)) == "Your team wins"
    assert verdict(info, (2, 1, 1), (7, 9, 3)) == "patrol wins"
    info = MatchInfo.of(ArenaConfig(prey=1), ("a", "b", "c", "d", "you"))
    assert verdict(info, (1, 2, 3, 4, 1), (9, 3, 2, 1, 1)) == "You were caught 1 time"
