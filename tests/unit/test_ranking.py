"""R7.1's order of rivals that are equally far."""

from itertools import product

import pytest

from catch_arena.core.ranking import precedes
from catch_arena.layout import TeamRivalFeatures


@pytest.mark.rule("R7.1")
def test_r7_1_of_two_rivals_one_precedes_the_other_and_not_the_other_way_round() -> None:
    """Whatever differs between them: without this, the order would hang on that in which they come."""
    rivals = [TeamRivalFeatures(*looks) for looks in product((0.0, 1.0), repeat=len(TeamRivalFeatures._fields))]
    for one, other in product(rivals, repeat=2):
        assert precedes(one, other, True) != precedes(other, one, False)
