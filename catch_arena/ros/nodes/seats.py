"""Hunters that ROS nodes drive, and their commands while a node is silent."""

import math
from typing import Final

from catch_arena.core.physics import WATCHDOG_MS
from catch_arena.messages import Twist
from catch_arena.ros.middleware.bus import Log, OnceLog
from catch_arena.ros.middleware.interfaces import TwistMessage

STANDING_STILL: Final = Twist(0.0, 0.0)
_FASTEST: Final = 1e9
"""Bound of the speeds and turn rates in a Twist, far above every limit of R2.5, which the arena applies later."""


class RosSeat:
    """One hunter. Its node drives it until the node has been silent for as long as a Twist holds.

    Args:
        hunter: name of the hunter.
        log: takes one line when the seat's state changes.
        only_drives: whether the arena requests the targets in its reach (R4.4), and not its node.
    """

    def __init__(self, hunter: str, log: Log, *, only_drives: bool = False) -> None:
        self.hunter, self.only_drives = hunter, only_drives
        self.driven = False
        """True while a node drives it."""
        self._log, self._log_once = log, OnceLog(log)
        self._twist = STANDING_STILL
        self._has_new_twist = False
        self._is_missing = True
        """True if the next Twist is logged: no node has driven the hunter yet, or its silence was logged."""
        self.drove = False
        """True if a node ever drove it."""
        self._had_publishers = self._has_left = False
        """True if a node that could drive it was on the bus; if one has left."""
        self._last_twist_ms = -WATCHDOG_MS

    def on_twist(self, message: TwistMessage) -> None:
        """Take a Twist; the last one before a step counts."""
        speed, turn_rate = message.linear.x, message.angular.z
        if not (math.isfinite(speed) and math.isfinite(turn_rate)):
            self._log_once.warn(f"{self.hunter}: a Twist that is not finite is ignored")
            return
        if message.linear.y != 0.0:
            self._log_once.warn(f"{self.hunter}: its node sends linear.y, which turtles ignore: turn instead")
        if not self.driven and self._is_missing:
            self._log(f"{self.hunter}: its node {'is back' if self._has_left else 'is there'}")
        self.driven = self.drove = True
        self._twist = Twist(*(min(max(value, -_FASTEST), _FASTEST) for value in (speed, turn_rate)))
        self._has_new_twist = True

    def command(self, now_ms: int, tick_ms: int, *, targets: bool = True) -> Twist:
        """R2.4: return the last Twist in each step, and zero at the first tick more than a second after it came.

        Args:
            now_ms: beginning of the step [ms]; a Twist that came since the previous step counts from then.
            tick_ms: time of the step's tick [ms].
            targets: whether there is a target to drive to; without one, silence of a node is not logged.
        """
        if self._has_new_twist:
            self._has_new_twist = False
            self._last_twist_ms = now_ms
        if tick_ms - self._last_twist_ms > WATCHDOG_MS:
            if self.driven:
                self._leave("is silent", logged=targets)
            return STANDING_STILL
        return self._twist

    def look_for(self, publishers: int | None) -> None:
        """Log that its node has left the bus, or that several nodes may drive it.

        Args:
            publishers: the number of nodes that can drive it; None if the bus does not report it.
        """
        if publishers is None:
            return
        if self.driven and publishers > 1:
            self._log_once.warn(
                f"{self.hunter}: {publishers} nodes may drive it, and this bus does not report which one "
                "sends: all are obeyed",
                "two",
            )
        gone = self._had_publishers and not publishers
        if gone and not self.drove:
            self._log(f"{self.hunter}: its node has gone, and never drove: look for an error in its terminal")
        elif not publishers and (self.driven or (gone and not self._is_missing)):  # or its silence was not logged
            self._leave("has gone")
        self._had_publishers = bool(publishers)

    def stop(self) -> None:
        """Stand still until the next Twist."""
        self._twist, self._has_new_twist = STANDING_STILL, False
        self._last_twist_ms = -WATCHDOG_MS

    def _leave(self, state: str, *, logged: bool = True) -> None:
        self.driven, self._is_missing = False, logged
        self.stop()
        if logged:
            self._has_left = True
            self._log(f"{self.hunter}: its node {state}; the hunter stands still until a node drives it again")
