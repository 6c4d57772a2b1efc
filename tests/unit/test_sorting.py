"""The sorting behind R7.1's order: right for every input, compiled and interpreted, in one lane and in eight."""

import numpy as np
import pytest

from catch_arena.core.addresses import by_address
from catch_arena.core.jit import unkept_entry
from catch_arena.core.ranking import FAR, sort_keys
from catch_arena.core.state import LANES, MOST, span
from catch_arena.core.vectors import HALF, SINGLE, WIDE


@unkept_entry
def sort(keys, count, ranks, width):
    for first in range(0, span(width), len(width)):
        sort_keys(by_address(keys), count, ranks, first, width)


@pytest.mark.parametrize("width", [SINGLE, HALF, WIDE], ids=["one", "four", "eight"])
@pytest.mark.parametrize("count", [*range(1, 18), 31, 32, 33, 63, 64])
def test_the_smallest_keys_come_first_in_order_and_none_is_lost(count, width):
    rng = np.random.default_rng(count)
    lanes = LANES if len(width) > 1 else 1
    for ranks in sorted({1, min(8, count), min(17, count), count, count + 1}):
        keys = np.full((MOST, LANES), -7, dtype=np.int32)  # what another seat has left there
        keys[:count] = rng.permuted(np.tile(np.arange(count), (LANES, 1)), axis=1).T
        keys[0, :3] = FAR
        expected = np.sort(keys[:count], axis=0)
        sort(keys.reshape(-1), count, ranks, width)
        assert (keys[: min(ranks, count), :lanes] == expected[:ranks, :lanes]).all()
        assert (np.sort(keys[:count], axis=0)[:, :lanes] == expected[:, :lanes]).all()
        assert (keys[count:] == -7).all()
