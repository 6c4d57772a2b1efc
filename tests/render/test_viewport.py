"""Colours and names."""

import itertools

import numpy as np
import pytest

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.render.match_info import HUNTER_COLORS, MatchInfo
from catch_arena.render.viewport import GROUND, TARGET, TARGET_TRAIL, TRACE


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


def ciede2000(one: np.ndarray, other: np.ndarray) -> float:
    """The difference of two colours in CIE Lab, as Sharma, Wu and Dalal (2005) write it out."""
    (light_1, a_1, b_1), (light_2, a_2, b_2) = one, other
    chroma = (np.hypot(a_1, b_1) + np.hypot(a_2, b_2)) / 2
    grow = 1.5 - 0.5 * np.sqrt(chroma**7 / (chroma**7 + 25.0**7))
    chroma_1, chroma_2 = np.hypot(grow * a_1, b_1), np.hypot(grow * a_2, b_2)
    hue_1, hue_2 = (np.degrees(np.arctan2(b, grow * a)) % 360 for a, b in ((a_1, b_1), (a_2, b_2)))
    turn = (hue_2 - hue_1 + 180) % 360 - 180
    hue = (hue_1 + turn / 2) % 360
    light, chroma = (light_1 + light_2) / 2, (chroma_1 + chroma_2) / 2
    weight = 1 - 0.17 * np.cos(np.radians(hue - 30)) + 0.24 * np.cos(np.radians(2 * hue))
    weight += 0.32 * np.cos(np.radians(3 * hue + 6)) - 0.20 * np.cos(np.radians(4 * hue - 63))
    d_light = (light_2 - light_1) / (1 + 0.015 * (light - 50) ** 2 / np.sqrt(20 + (light - 50) ** 2))
    d_chroma = (chroma_2 - chroma_1) / (1 + 0.045 * chroma)
    d_hue = 2 * np.sqrt(chroma_1 * chroma_2) * np.sin(np.radians(turn / 2)) / (1 + 0.015 * chroma * weight)
    rotation = -2 * np.sqrt(chroma**7 / (chroma**7 + 25.0**7))
    rotation *= np.sin(np.radians(60 * np.exp(-(((hue - 275) / 25) ** 2))))
    return float(np.sqrt(d_light**2 + d_chroma**2 + d_hue**2 + rotation * d_chroma * d_hue))


@pytest.mark.parametrize(
    ("one", "other", "difference"),
    [
        ((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425),
        ((50.0, 2.5, 0.0), (73.0, 25.0, -18.0), 27.1492),
        ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
        ((2.0776, 0.0795, -1.1350), (0.9033, -0.0636, -0.5514), 0.9082),
    ],
)
def test_the_measure_of_differences_is_the_published_one(one, other, difference):
    """Pairs from the authors' own table."""
    assert ciede2000(np.array(one), np.array(other)) == pytest.approx(difference, abs=1e-4)


@pytest.mark.parametrize("sight", _SIGHTS)
def test_eight_hunters_keep_apart_for_every_sight(sight):
    """From each other, the ground and the targets; 10 is plain at a glance, and the shells bear numbers besides."""
    seen = [lab(color, sight) for color in [*HUNTER_COLORS, GROUND, TARGET]]
    assert min(ciede2000(a, b) for a, b in itertools.combinations(seen, 2)) > 12.5
    trail = lab(TARGET_TRAIL, sight)
    assert min(ciede2000(trail, other) for other in [*seen, lab(TRACE, sight)]) > 12.5


def test_sixty_four_hunters_have_colours_and_neighbours_in_the_table_differ():
    info = MatchInfo.of(ArenaConfig(hunters=64))
    colors = [info.color(seat) for seat in range(64)]
    assert len(set(colors)) == 24
    assert all(a != b for a, b in itertools.pairwise(colors))


@pytest.mark.parametrize("sight", _SIGHTS)
@pytest.mark.parametrize(("teams", "least"), [(2, 15.0), (3, 12.5), (4, 9.0)])
def test_hunters_of_up_to_four_teams_are_told_apart_by_their_colours_in_every_shade(sight, teams, least):
    """Those of different teams; members of one have numbers. And nobody is taken for the ground or a target."""
    seats = tuple(tuple(range(4 * team, 4 * team + 4)) for team in range(teams))
    info = MatchInfo.of(ArenaConfig(hunters=4 * teams, teams=seats))
    seen = [[lab(info.color(seat), sight) for seat in team] for team in seats]
    assert min(ciede2000(a, b) for one, other in itertools.combinations(seen, 2) for a in one for b in other) > least
    around = [lab(GROUND, sight), lab(TARGET, sight)]
    assert min(ciede2000(a, b) for team in seen for a in team for b in around) > 9.0
    for team in seats:
        assert len({info.color(seat) for seat in team}) == 4


def test_a_team_is_called_as_its_only_agent_or_by_its_colour():
    config = ArenaConfig(hunters=6, teams=((0, 1), (2, 3), (4, 5)))
    info = MatchInfo.of(config, ("a", "a", "b", "c", "d", "d"))
    assert [contender.name for contender in info.contenders] == ["a", "mint", "d"]
    assert [contender.name for contender in MatchInfo.of(config, ("a",) * 6).contenders] == ["amber", "mint", "purple"]
    assert MatchInfo.of(config).contender_by_seat == (0, 0, 1, 1, 2, 2)
    many = MatchInfo.of(ArenaConfig(hunters=64, teams=tuple((seat,) for seat in range(64))), ("a",) * 64)
    assert [many.contenders[team].name for team in (0, 8, 16)] == ["amber", "light amber", "dark amber"]


def test_the_seats_of_one_agent_have_rings_of_different_pieces():
    assert MatchInfo.of(ArenaConfig(), ("a", "b", "a", "a")).rings == (1, 1, 2, 3)
    assert MatchInfo.of(ArenaConfig()).rings == (1, 1, 1, 1)
