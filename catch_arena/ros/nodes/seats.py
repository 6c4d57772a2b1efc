"""Hunters that ROS nodes drive: who drives which, and what each does while its node is silent."""

import math
from collections.abc import Callable
from typing import Final

from catch_arena.core.physics import WATCHDOG_MS
from catch_arena.messages import Twist
from catch_arena.ros.middleware.bus import Log, Peer
from catch_arena.ros.middleware.interfaces import TwistMessage

STANDING_STILL: Final = Twist(0.0, 0.0)
_FASTEST: Final = 1e9
"""Far beyond every limit of R2.5, which comes later; numbers so large are finite, and no more than that."""


class RosSeat:
    """One hunter. It belongs to the node that drives it, until that has been silent for as long as a Twist holds.

    Args:
        hunter: its name.
        log: takes one line when the seat's state changes.
        only_drives: whether the arena asks for what is in its reach (R4.4), and its node does not.
    """

    def __init__(self, hunter: str, log: Log, *, only_drives: bool = False) -> None:
        self.hunter, self.only_drives = hunter, only_drives
        self.driver: Peer | None = None
        """Who drives it, where the middleware tells."""
        self.driven = False
        """Whether somebody does."""
        self._log = log
        self._twist = STANDING_STILL
        self._fresh = False
        self._missed = True
        """Whether it is news that a node drives it."""
        self._was_there = self._drove = False
        """Whether a node that could drive it was on the bus, and whether one ever did."""
        self._given_ms = -WATCHDOG_MS
        self._logged: set[str] = set()

    def on_twist(self, message: TwistMessage, peer: Peer | None) -> None:
        """A Twist; the last one before a step counts."""
        if self.driven and peer != self.driver:
            self._log_once(
                "two",
                f"warning: {self.hunter}: a second node drives it; it is not heard while the first one sends",
            )
            return
        speed, turn_rate = message.linear.x, message.angular.z
        if not (math.isfinite(speed) and math.isfinite(turn_rate)):
            self._log_once("finite", f"warning: {self.hunter}: a Twist that is not finite is left out")
            return
        if message.linear.y != 0.0:
            self._log_once(
                "sideways", f"warning: {self.hunter}: its node sends linear.y, which is not obeyed: turn instead"
            )
        if not self.driven:
            if self._missed:
                self._log(f"{self.hunter}: its node {'is back' if 'gone' in self._logged else 'is there'}")
            self._logged.discard("two")
        self.driver, self.driven, self._drove = peer, True, True
        self._twist = Twist(*(min(max(value, -_FASTEST), _FASTEST) for value in (speed, turn_rate)))
        self._fresh = True

    def command(self, now_ms: int, tick_ms: int, *, targets: bool = True) -> Twist:
        """R2.4: the last Twist, repeated in each step, and zero at the first tick more than a second after it came.

        Args:
            now_ms: when the step begins; a Twist that was heard since the step before is given then.
            tick_ms: when the step's tick is.
            targets: whether there is a target to drive to: without one, to be silent is no news.
        """
        if self._fresh:
            self._fresh = False
            self._given_ms = now_ms
        if tick_ms - self._given_ms > WATCHDOG_MS:
            if self.driven:
                self._leave("is silent", tell=targets)
            return STANDING_STILL
        return self._twist

    def look_for(self, publishers: frozenset[Peer] | None) -> None:
        """Whether its driver is still on the bus, and, where the middleware does not tell who sends, the only one."""
        if publishers is None:
            return
        if self.driven and self.driver is None and len(publishers) > 1:
            self._log_once(
                "two",
                f"warning: {self.hunter}: {len(publishers)} nodes may drive it, and this bus does not tell which of "
                "them sends: all are heard",
            )
        gone = self._was_there and not publishers
        if self.driven and (self.driver not in publishers if self.driver is not None else not publishers):
            self._leave("has gone")
        elif gone and not self._drove:
            self._log(f"{self.hunter}: its node has gone, and never drove: look for an error in its terminal")
        elif gone and not self._missed:  # it was silent, and that was no news
            self._leave("has gone")
        self._was_there = bool(publishers)

    def stop(self) -> None:
        """It stands still until the next Twist."""
        self._twist, self._fresh = STANDING_STILL, False
        self._given_ms = -WATCHDOG_MS

    def _leave(self, how: str, *, tell: bool = True) -> None:
        self.driven, self.driver, self._missed = False, None, tell
        self.stop()
        if not tell:
            return
        self._logged.add("gone")
        self._log(f"{self.hunter}: its node {how}; the hunter stands still until one drives it again")

    def _log_once(self, what: str, line: str) -> None:
        if what not in self._logged:
            self._logged.add(what)
            self._log(line)


def seat_of(peer: Peer | None, seats: list[RosSeat], warn: Callable[[str], object]) -> RosSeat | None:
    """Whose request it is that came to the service which all share: that of the hunter that its sender drives.

    Args:
        peer: who asks, where the middleware tells.
        seats: those that nodes drive.
        warn: takes one line that says why it is nobody's.
    """
    if len(seats) == 1:
        return seats[0]
    if peer is None:
        warn(
            "this bus does not tell who asks at /catch_turtle: ask at /hunter_0/catch_turtle and its like, as with "
            "--ros-args -r /catch_turtle:=/hunter_0/catch_turtle"
        )
        return None
    driven = [seat for seat in seats if seat.driver == peer]
    if len(driven) == 1:
        return driven[0]
    which = "several hunters" if driven else "no hunter"
    warn(f"a node that drives {which} asks at /catch_turtle: /hunter_0/catch_turtle and its like say who asks")
    return None
