"""R7.5's limits, kept as squares of distances, decide as distances in whole micrometres do."""

import math
from random import Random

import pytest

from catch_arena.config import ArenaConfig
from catch_arena.core.arbiter import measure_um
from catch_arena.core.visibility import is_seen, squared_limit
from catch_arena.engine.core_settings import settings_of

LIMITS_UM = [0, 1, 2, 3, 7, 300_000, 500_000, 2_500_000, 11_088_889, 7_071_067_812, 10**10]


@pytest.mark.rule("R7.5")
@pytest.mark.parametrize("limit_um", [*LIMITS_UM, *(Random(1).randrange(1, 10**8) for _ in range(20))])
def test_r7_5_a_square_below_the_limit_is_a_distance_of_fewer_micrometres(limit_um: int) -> None:
    """At the edge and the 2,000 numbers on both sides of it, and anywhere; measured as the rulebook says."""
    limit = squared_limit(limit_um)
    source = Random(limit_um)
    squares = [limit, *(limit * source.uniform(0.0, 2.0) for _ in range(1000))]
    below = above = limit
    for _ in range(2000):
        below, above = math.nextafter(below, 0.0), math.nextafter(above, math.inf)
        squares += [below, above]
    for square in squares:
        distance_um = math.floor(1000000.0 * math.sqrt(square) + 0.5)
        assert (square < limit) == (distance_um < limit_um)


@pytest.mark.rule("R7.5")
def test_r7_5_a_place_is_within_a_limit_where_its_distance_is() -> None:
    """A few micrometres to either side of a view of 2.5 m, in all directions."""
    limit = squared_limit(2_500_000)
    for degree in range(0, 360, 7):
        for um in range(-3, 4):
            dx, dy = ((2.5 + um / 1e6) * turn(math.radians(degree)) for turn in (math.cos, math.sin))
            assert (dx * dx + dy * dy < limit) == (measure_um(dx, dy) < 2_500_000)


@pytest.mark.rule("R7.5")
def test_r7_5_what_is_at_the_very_limit_is_not_within_it() -> None:
    """In all directions, and of the reach as well; 1.5 and 2.5 m have squares without rounding."""
    s = settings_of(ArenaConfig(view_radius_m=9.0), with_parts=False)._replace(view_limit_m2=6.25)
    for dx, dy, seen in ((2.5, 0.0, False), (-2.5, 0.0, False), (0.0, 1.5, True), (1.5, 2.0, False)):
        assert is_seen(dx, dy, 0.0, 1.0, 0.0, s) == seen
    near = s._replace(view_limit_m2=0.0)
    for dx, seen in ((1.5, False), (1.4999999999999998, True)):
        assert is_seen(dx, 0.0, 0.0, 1.0, 2.25, near) == seen
