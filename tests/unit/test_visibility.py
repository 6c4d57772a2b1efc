"""R7.5's limits are those of distances in whole micrometres."""

import pytest

from catch_arena.config import ArenaConfig
from catch_arena.core.visibility import is_seen
from catch_arena.engine.core_settings import settings_of


@pytest.mark.rule("R7.5")
def test_r7_5_what_is_at_the_very_limit_is_not_within_it() -> None:
    """In all directions, and of the reach as well; half a micrometre less rounds to the limit too."""
    s = settings_of(ArenaConfig(view_radius_m=2.5))
    for dx, dy, seen in ((2.5, 0.0, False), (-2.4999996, 0.0, False), (-2.4999994, 0.0, True), (1.5, 2.0, False)):
        assert is_seen(dx, dy, 0.0, 1.0, 0.0, s) == seen
    near = settings_of(ArenaConfig(view_radius_m=0.1))
    for dx, seen in ((1.5, False), (1.4999996, False), (1.4999994, True)):
        assert is_seen(dx, 0.0, 0.0, 1.0, 1_500_000.0, near) == seen
