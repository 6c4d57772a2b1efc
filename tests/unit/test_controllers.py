"""R4.3's loop works off an integral that saturates, in states that no match leads to."""

import pytest

from catch_arena.core.controllers import pi_step


@pytest.mark.parametrize("error", [-0.5, -2.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_integral_that_saturates_the_output_is_worked_off(error: float, sign: float) -> None:
    """Growth is undone in the output's direction alone: an error to the other side counts."""
    output, integral = pi_step(sign * error, sign * 100.0, 1.0, 1.0, -3.0, 3.0, 0.1)
    assert output == sign * 3.0
    assert integral == sign * (100.0 + 0.1 * error)
