"""Exactly one of two seats that ask for a target is preferred, whatever the lots."""

import numpy as np
import pytest

from catch_arena.core.arbiter import FIRST_COME, NEAREST, is_preferred
from catch_arena.core.jit import entry


@entry
def prefers(policy: int, one: int, other: int) -> bool:
    """Lets Python call a rule that only compiled code calls."""
    return is_preferred(policy, np.uint64(5), 3, 7, one, 100_000, other, 100_000)


@pytest.mark.parametrize("policy", [NEAREST, FIRST_COME])
def test_of_two_hunters_equally_near_one_is_preferred_and_nobody_to_itself(policy):
    """R5.5, R5.9: the lots of two seats are never equal, since A.5's mix is a permutation; so nothing else shows it."""
    for one in range(16):
        for other in range(16):
            assert prefers(policy, one, other) + prefers(policy, other, one) == (one != other)
