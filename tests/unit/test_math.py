"""Short cuts of the core's own arithmetic give the bits of the book's formulas (A.2), and where R7.1's order rounds."""

import math

import numpy as np

from catch_arena.core.math import PI, below_pi, wrap
from catch_arena.core.ranking import key_of


def neighbours(number: float, count: int) -> list[float]:
    """The doubles next to a number, on both sides, and itself."""
    found = [number]
    for goal in (-math.inf, math.inf):
        at = number
        for _ in range(count):
            at = math.nextafter(at, goal)
            found.append(at)
    return found


def test_an_angle_of_half_a_turn_at_most_is_wrapped_without_a_division() -> None:
    """The result is wrap's, bit for bit, up to the last doubles before pi, where its own division rounds."""
    angles = [*np.random.default_rng(3).uniform(-PI, PI, 10_000), *neighbours(PI, 40), *neighbours(-PI, 40), 0.0, -0.0]
    for angle in angles:
        if -PI <= angle <= PI:
            assert float(below_pi(angle)).hex() == float(wrap(angle)).hex()


def test_round_distances_are_not_where_the_order_of_what_is_seen_rounds() -> None:
    """Two that are equally far by symmetry differ in their last bits, and are still equally near: at round distances,
    where there is much symmetry, no key changes within a thousand doubles.
    """
    for length in (0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 8.0, 10.0):
        keys = {int(key_of(dx, 0.0, 0)) for dx in neighbours(length, 500)}
        assert len(keys) == 1


def test_the_order_of_what_is_seen_is_that_of_distance_to_four_parts_in_a_million() -> None:
    """Slots order equal ones."""
    lengths = np.sort(np.random.default_rng(4).uniform(0.01, 16.0, 2000))
    near = [int(key_of(float(length), 0.0, 0)) // 64 for length in lengths]
    assert near == sorted(near)
    for shorter, longer, one, other in zip(lengths, lengths[1:], near, near[1:], strict=False):
        assert one < other or longer - shorter < 4e-6 * longer
    assert key_of(1.0, 1.0, 3) < key_of(1.0, 1.0, 4)
