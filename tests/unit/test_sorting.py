"""The sorting behind R7.1's order: right for every input, compiled and interpreted, in one lane and in eight."""

import numpy as np
import pytest

from catch_arena.core.addresses import by_address
from catch_arena.core.jit import unkept_entry
from catch_arena.core.ranking import FAR, sort_keys
from catch_arena.core.sorting import merged, sorted_bitonic, sorted_eight
from catch_arena.core.state import LANES, MOST, span
from catch_arena.core.vectors import HALF, SINGLE, WIDE

BITS = (np.arange(256)[:, None] >> np.arange(8)) & 1
"""By the 0-1 principle, what sorts every row of zeros and ones sorts everything."""


def test_every_eight_is_sorted():
    assert (np.sort(BITS, axis=1) == np.array(sorted_eight(tuple(BITS.T))).T).all()


def test_two_eights_become_the_smaller_half_in_order_and_a_rest_that_can_be_sorted():
    """All pairs of sorted rows of zeros and ones, and numbers, of which none is lost."""
    rows = np.sort(np.random.default_rng(1).permuted(np.tile(np.arange(16), (500, 1)), axis=1).reshape(-1, 2, 8))
    bits = np.sort(
        [(one, other) for one in np.unique(np.sort(BITS), axis=0) for other in np.unique(np.sort(BITS), axis=0)]
    )
    for pairs in (rows, bits):
        low, high = merged(tuple(pairs[:, 0].T), tuple(pairs[:, 1].T))
        expected = np.sort(pairs.reshape(-1, 16))
        assert (expected[:, :8] == np.array(low).T).all()
        assert (expected[:, 8:] == np.array(sorted_bitonic(high)).T).all()


@unkept_entry
def sort(keys, count, ranks, width):
    for first in range(0, span(width), len(width)):
        sort_keys(by_address(keys), count, ranks, first, width)


@pytest.mark.parametrize("width", [SINGLE, HALF, WIDE], ids=["one", "four", "eight"])
@pytest.mark.parametrize("count", [*range(1, 18), 31, 32, 33, 63, 64])
def test_the_smallest_keys_come_first_in_order_and_none_is_lost(count, width):
    """Behind them stand the others, among some that are FAR."""
    rng = np.random.default_rng(count)
    lanes = LANES if len(width) > 1 else 1
    for ranks in sorted({1, min(8, count), min(9, count), min(17, count), count}):
        keys = np.full((MOST, LANES), -7, dtype=np.int32)  # what another seat has left there
        keys[:count] = rng.permuted(np.tile(np.arange(count), (LANES, 1)), axis=1).T
        keys[0, :3] = FAR
        expected = np.sort(keys[:count], axis=0)
        sort(keys.reshape(-1), count, ranks, width)
        assert (keys[:ranks, :lanes] == expected[:ranks, :lanes]).all()
        whole = -(-count // 8) * 8
        assert (np.sort(keys[:whole], axis=0)[:count, :lanes] == expected[:, :lanes]).all()
        assert (keys[whole:] == -7).all()
