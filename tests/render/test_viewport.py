"""Hunters and teams have names, colours and rings that tell them apart."""

import itertools
import math

import numpy as np
import pytest

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.render.match_info import HUNTER_COLORS, MatchInfo
from catch_arena.render.viewport import GROUND, TARGET, TARGET_TRAIL


def test_names_must_fit_the_seats():
    with pytest.raises(ConfigError, match="names must have one for each of 4 hunters, got 3"):
        MatchInfo.of(ArenaConfig(), ["a", "b", "c"])


# Machado, Oliveira and Fernandes (2009), severity 1, on linear RGB
_SIGHTS = {
    "normal": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}


def lab(color, sight) -> np.ndarray:
    """A colour as somebody of that sight sees it, in CIE Lab."""
    part = np.array(color) / 255.0
    linear = np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)
    seen = np.clip(np.array(_SIGHTS[sight]) @ linear, 0.0, 1.0)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    xyz = to_xyz @ seen / [0.9505, 1.0, 1.089]
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("sight", _SIGHTS)
def test_eight_hunters_keep_apart_for_every_sight(sight):
    """Colours of hunters differ from each other, the ground and the targets in CIE Lab."""
    seen = [lab(color, sight) for color in [*HUNTER_COLORS, GROUND, TARGET]]
    assert min(math.dist(a, b) for a, b in itertools.combinations(seen, 2)) > 14
    trail = lab(TARGET_TRAIL, sight)
    assert min(math.dist(trail, other) for other in seen) > 14


def test_sixty_four_hunters_have_colours_and_neighbours_in_the_table_differ():
    info = MatchInfo.of(ArenaConfig(hunters=64))
    colors = [info.colors[seat] for seat in range(64)]
    assert len(set(colors)) == 24
    assert all(a != b for a, b in itertools.pairwise(colors))


def test_a_team_is_called_as_its_only_agent_or_by_its_colour():
    config = ArenaConfig(hunters=6, teams=((0, 1), (2, 3), (4, 5)))
    info = MatchInfo.of(config, ("a", "a", "b", "c", "d", "d"))
    assert [contender.name for contender in info.contenders] == ["a", "mint", "d"]
    assert [contender.name for contender in MatchInfo.of(config, ("a",) * 6).contenders] == ["amber", "mint", "purple"]
    many = MatchInfo.of(ArenaConfig(hunters=64, teams=tuple((seat,) for seat in range(64))), ("a",) * 64)
    assert [many.contenders[team].name for team in (0, 8, 16)] == ["amber", "light amber", "dark amber"]


def test_the_seats_of_one_agent_have_rings_of_different_pieces():
    assert MatchInfo.of(ArenaConfig(), ("a", "b", "a", "a")).rings == (1, 1, 2, 3)
    assert MatchInfo.of(ArenaConfig()).rings == (1, 1, 1, 1)
