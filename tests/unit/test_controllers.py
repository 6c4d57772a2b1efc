"""R4.3's loop by itself, in states that no match leads to, and hunters of several lanes (R1.6)."""

import numpy as np
import pytest

from catch_arena.config import ArenaConfig
from catch_arena.core.controllers import pi_step
from catch_arena.engine import Engine
from catch_arena.verdicts import Verdict


@pytest.mark.parametrize("error", [-0.5, -2.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_integral_that_saturates_the_output_is_worked_off(error: float, sign: float) -> None:
    """Growth is undone in the output's direction alone: an error to the other side counts."""
    output, integral = pi_step(sign * error, sign * 100.0, 1.0, 1.0, -3.0, 3.0, 0.1)
    assert output == sign * 3.0
    assert integral == sign * (100.0 + 0.1 * error)


def test_only_the_hunters_that_are_withdrawn_hold() -> None:
    """Under target control, in some rows of a batch: every row reads its own flag."""
    config = ArenaConfig(hunters=2, initial_targets=3)
    engine = Engine(config, 5)
    engine.reset(range(5))
    for row in (1, 3):
        engine.withdraw(row, 0)
    engine.step(np.ones((5, 2), np.int64), np.zeros((5, 2, 2), np.float32))
    for row in range(5):
        speeds = [hunter.linear_velocity for hunter in engine.world(row).hunters]
        assert [speed > 0.0 for speed in speeds] == [row not in (1, 3), True], f"row {row}"


def test_every_row_has_its_own_wish() -> None:
    """R4.1, R5.2: one row after the other asks for a rank without a target; the far target is not requested."""
    config = ArenaConfig(hunters=1)
    for odd in range(5):
        engine = Engine(config, 5)
        engine.reset(range(5))
        for row in range(5):
            engine.place(row, [(1.0, 1.0, 0.0)], [(9.0, 9.0)])
        ranks = np.ones((5, 1), np.int64)
        ranks[odd] = 2
        engine.step(ranks, np.zeros((5, 1, 2), np.float32))
        for row in range(5):
            verdicts = [ruling.verdict for ruling in engine.rulings(row)]
            assert verdicts == ([Verdict.MALFORMED] if row == odd else []), f"row {row}, {odd} asks in vain"
