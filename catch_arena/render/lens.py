"""The lens: an inset that spreads the hunters of a contest around their target, with their distances as lines.

Pure functions. The page's player draws the same claimants (player/page/arena.js).
"""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

from catch_arena.explanation.facts import Contest
from catch_arena.explanation.formatting import millimetres
from catch_arena.render import hud
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import INK, WHITE, Box, Label, Path, Ring, Shape, Turtle
from catch_arena.render.text import text_width
from catch_arena.render.viewport import GROUND, TARGET, Viewport
from catch_arena.world import World

LENS_MS: Final = 2500.0
"""Time for which a lens is shown [ms]."""
SIZE: Final = 0.36
"""Side of a lens, as a part of the arena's shorter side."""
MOST_CLAIMANTS: Final = 4
"""Greatest number of hunters in a lens: the winner and the nearest others."""
LEAST_ARENA: Final = 320
"""Shorter side of the smallest arena with a lens [pixels]; in a smaller one its texts could not be read."""
_APART_RAD: Final = math.radians(70.0)
"""Least angle between two hunters in a lens; their distances stay to scale."""
GROWS_MS: Final = 160.0
"""Time in which a lens grows at first, and shrinks at last [ms]."""


class Claimant(NamedTuple):
    """Hunter in a lens."""

    seat: int
    distance_um: int
    """Distance to the target [micrometres]."""
    direction: float
    """Direction from the target in which the hunter is drawn, counter-clockwise from the x axis [rad]."""
    theta: float
    """Heading of the hunter [rad]."""


class Lens(NamedTuple):
    """Contest as the lens shows it."""

    contest: Contest
    claimants: tuple[Claimant, ...]
    """Hunters of the first claims."""
    corner: tuple[int, int]
    """Corner of the arena that is farthest from all hunters: 0 or 1 for left or right, and for bottom or top."""


def lens_of(before: World, contest: Contest) -> Lens:
    """Return the lens of a contest that was judged on a world."""
    hunters, side_m, claims = before.hunters, before.side_m, contest.claims[:MOST_CLAIMANTS]
    place = next((one.x, one.y) for one in before.targets if one.name == contest.target)
    true = [math.atan2(hunters[claim.seat].y - place[1], hunters[claim.seat].x - place[0]) for claim in claims]
    claimants = tuple(
        Claimant(claim.seat, claim.distance_um or 0, direction, hunters[claim.seat].theta)
        for claim, direction in zip(claims, spread_directions(true), strict=True)
    )
    occupied = [place, *((hunter.x, hunter.y) for hunter in hunters)]
    corners = [(right, top) for top in (1, 0) for right in (1, 0)]
    corner = max(
        corners, key=lambda corner: min(math.dist((corner[0] * side_m, corner[1] * side_m), at) for at in occupied)
    )
    return Lens(contest, claimants, corner)


def spread_directions(directions: Sequence[float]) -> list[float]:
    """Return directions [rad], with those that are closer than 70 degrees turned apart."""
    turned = [direction + 1e-3 * index for index, direction in enumerate(directions)]
    for _ in range(40):
        for first in range(len(turned)):
            for second in range(first + 1, len(turned)):
                between = math.remainder(turned[second] - turned[first], 2.0 * math.pi)
                push = 0.5 * math.copysign(max(0.0, _APART_RAD - abs(between)), between)
                turned[first] -= push
                turned[second] += push
    return turned


def lens_shapes(viewport: Viewport, info: MatchInfo, lens: Lens, age_ms: float) -> list[Shape]:
    """Return the shapes of a lens in its corner of the arena; it grows at first and shrinks at last."""
    room = min(viewport.width, viewport.height)
    part = min(1.0, (age_ms + 20.0) / GROWS_MS, (LENS_MS - age_ms) / GROWS_MS)
    size = SIZE * room * part * (2.0 - part)
    gap, right, top = 0.025 * room, *lens.corner
    left = viewport.width - gap - size if right else gap
    away = gap + hud.CAPTION * room  # a caption may stand there
    upper = away if top else viewport.height - away - size
    return _inset(left, upper, size, info, lens)


def result_text(contest: Contest) -> str:
    """Return what decided a contest: the difference of the two least distances, the queue, or a draw."""
    if contest.clause == "R5.9":
        return "first in the queue"
    behind_um = contest.behind_um(contest.claims[1])
    return "equally near: by draw" if behind_um is None else f"{millimetres(behind_um)} nearer"


def _inset(left: float, top: float, size: float, info: MatchInfo, lens: Lens) -> list[Shape]:
    edge, unit = max(1.5, 0.012 * size), size / 240.0
    x, y = left + 0.5 * size, top + 0.345 * size
    scale = 0.25 * size / max(1, *(claimant.distance_um for claimant in lens.claimants))
    text = hud.font_size(15 * unit, 7)
    winner = lens.claimants[0]
    shapes: list[Shape] = [
        Box(left, top, size, size, WHITE, 0.07 * size),
        Box(left + edge, top + edge, size - 2.0 * edge, size - 2.0 * edge, GROUND, 0.06 * size),
        Ring(x, y, winner.distance_um * scale, max(1.0, 0.008 * size), WHITE, 0.6, pieces=24),
    ]
    for claimant in reversed(lens.claimants):
        away = claimant.distance_um * scale
        end = (x + math.cos(claimant.direction) * away, y - math.sin(claimant.direction) * away)
        shapes += [
            Path(((x, y), end), 7 * unit, INK),
            Path(((x, y), end), 4 * unit, info.colors[claimant.seat]),
            Turtle(*end, claimant.theta, 46 * unit, info.colors[claimant.seat]),
            Label(*end, info.number(claimant.seat), text, WHITE, 800, "center", outline=INK),
        ]
    shapes.append(Turtle(x, y, 0.5 * math.pi, 28 * unit, TARGET, contrast=0.6))
    panel = top + 0.68 * size
    shapes.append(Box(left + edge, panel, size - 2.0 * edge, 0.32 * size - edge, hud.PANEL, 0.055 * size))
    rows = [(claimant, millimetres(claimant.distance_um)) for claimant in lens.claimants[:2]]
    color = hud.legible(info.colors[winner.seat])
    right, middle = left + 0.95 * size, panel + 0.055 * size
    for claimant, distance in rows:
        shapes += hud.agent_chip(left + 0.05 * size, middle, info, claimant.seat, 0.9 * text)
        start = left + 0.05 * size + hud.chip_width(info, 0.9 * text) + 0.4 * text
        room = right - text_width(distance, text, 700) - 0.5 * text - start
        shapes += [
            Label(start, middle, info.names[claimant.seat], text, hud.BRIGHT, 600, max_width=room),
            Label(right, middle, distance, text, hud.BRIGHT, 700, "right"),
        ]
        middle += 0.1 * size
    shapes.append(Label(x, middle, result_text(lens.contest), text, color, 800, "center", max_width=0.9 * size))
    return shapes
