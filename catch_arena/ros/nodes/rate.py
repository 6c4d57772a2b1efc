"""Steps at an even rate, by the wall clock, as `rclpy.Rate` makes them."""

import time
from collections.abc import Callable
from typing import Final

from catch_arena import interrupts
from catch_arena.ros.middleware.bus import Bus

LATE_S: Final = 0.005
"""Delay [s] above which a tick counts as late."""
_SKIPPED_DELAY_S: Final = 0.25
"""Delay [s] above which missed ticks are not made up for: the next tick is due one period from now."""


class Rate:
    """Timer that waits for one tick after the other, `period_s` seconds apart by the wall clock."""

    def __init__(self, period_s: float) -> None:
        self.period_s = period_s
        self.ticks = 0
        self.late = 0
        """Number of ticks that began more than LATE_S after their time."""
        self.latest_s = 0.0
        """Longest delay of a tick [s]."""
        self._due = time.perf_counter()

    def sleep(self) -> None:
        """Wait until the next tick is due."""
        self._due += self.period_s
        remaining_s = self._due - time.perf_counter()
        if remaining_s > 0:
            time.sleep(remaining_s)
        delay_s = time.perf_counter() - self._due
        self.ticks += 1
        self.late += delay_s > LATE_S
        self.latest_s = max(self.latest_s, delay_s)
        if delay_s > _SKIPPED_DELAY_S:
            self._due = time.perf_counter()


def tick_until_signal(bus: Bus, tick: Callable[[], object], period_s: float) -> None:
    """Run a node until Ctrl-C: handle its messages and tick, in each period [s]."""
    rate = Rate(period_s)

    def tick_forever() -> None:
        while True:
            rate.sleep()
            bus.spin()
            tick()

    interrupts.run_until_signal(tick_forever)
