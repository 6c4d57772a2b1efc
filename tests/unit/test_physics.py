"""R1.3: rows of a chunk whose steps have fewer ticks meet no wall in the tick that they lack."""

import numpy as np

from catch_arena.config import ArenaConfig
from catch_arena.engine import Engine

ARENAS = 5
FRESH = (1, 2, 4)
"""The rows whose clock is at 0, with six ticks to come; the others' is at 300 ms, with seven."""


def test_a_wall_in_the_tick_that_a_lane_does_not_have_is_not_met() -> None:
    """At 2 m/s six ticks make 0.192 m and seven 0.224 m: seat 0 stands between, and seat 1 is at the wall anyway."""
    config = ArenaConfig(hunters=2, control="velocity", max_speed_mps=2.0, spawn_frequency_hz=0.0)
    ranks, forward = np.zeros((ARENAS, 2), np.int64), np.full((ARENAS, 2, 2), [1.0, 0.0], np.float32)
    engine = Engine(config, ARENAS)
    engine.reset(range(ARENAS))
    for _ in range(3):
        engine.step(ranks, forward)
    engine.reset(range(len(FRESH)), FRESH)
    poses = [(config.side_m - 0.208, 5.0, 0.0), (config.side_m - 0.1, 6.0, 0.0)]
    for row in range(ARENAS):
        engine.place(row, poses, [])
    engine.step(ranks, forward)
    for row in range(ARENAS):
        late, early = engine.world(row).hunters
        assert late.at_wall == (row not in FRESH), f"row {row}"
        assert (late.x == config.side_m) == (row not in FRESH), f"row {row}"
        assert early.at_wall, f"row {row}"
