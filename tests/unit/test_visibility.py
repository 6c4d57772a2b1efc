"""R7.5's limits as squares of distances."""

import math
from random import Random

import pytest

from catch_arena.core.arbiter import measure_um
from catch_arena.core.visibility import squared_limit

LIMITS_UM = [0, 1, 2, 3, 7, 300_000, 500_000, 2_500_000, 11_088_889, 7_071_067_812, 10**10]


@pytest.mark.rule("R7.5")
@pytest.mark.parametrize("limit_um", [*LIMITS_UM, *(Random(1).randrange(1, 10**8) for _ in range(20))])
def test_r7_5_a_square_below_the_limit_is_a_distance_of_fewer_micrometres(limit_um: int) -> None:
    """At the edge and the 2,000 numbers on both sides of it, and anywhere; measured as the rulebook says."""
    limit = squared_limit(limit_um)
    source = Random(limit_um)
    squares = [limit * source.uniform(0.0, 2.0) for _ in range(1000)]
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
