"""The player's JavaScript paints the grid and the numbers as render/ draws them."""

import json
from pathlib import Path

import pytest
from report.javascript import deno

import catch_arena
from catch_arena.player.bundle import css
from catch_arena.player.element import player_look
from catch_arena.render.hud import PANEL, readable_on
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.scene import GRID, ground_shapes
from catch_arena.render.viewport import Viewport

PAINTER = Path(__file__).with_name("paint.js")
ARENAS = [(2.0, 200), (11.0, 500), (11.0, 900), (40.0, 500), (250.0, 600), (5000.0, 300), (5000.0, 1200)]
"""(side [m], pixels of the picture)."""


def hunter_colors():
    """Return the colours of many hunters, alone and in teams."""
    alone = MatchInfo.of(catch_arena.ArenaConfig(hunters=64))
    paired = MatchInfo.of(
        catch_arena.ArenaConfig(hunters=64, teams=tuple((seat, seat + 1) for seat in range(0, 64, 2)))
    )
    return sorted({*alone.colors, *paired.colors, *(one.color for one in paired.contenders)})


@pytest.fixture(scope="module")
def painted():
    given = {"look": player_look(), "colors": list(map(css, hunter_colors())), "arenas": ARENAS}
    return json.loads(deno("run", "--no-remote", PAINTER, given=json.dumps(given)))


def test_the_grid_is_as_wide_as_in_pictures(painted):
    for (side, pixels), lines in zip(ARENAS, painted["lines"], strict=True):
        shapes = ground_shapes(Viewport(pixels, pixels, side))
        assert lines == sum(one.color == GRID for one in shapes), (side, pixels)
        assert lines < pixels / 10


def test_numbers_are_dark_on_the_colours_on_which_pictures_have_them_dark(painted):
    expected = [readable_on(color) == PANEL for color in hunter_colors()]
    assert painted["dark"] == expected
    assert set(expected) == {True, False}
