"""Hunters that ROS nodes drive: their commands while a node is silent, and advice for the authors of the nodes."""

import math
from collections.abc import Collection, Iterator, Sequence
from typing import Final, Literal

from catch_arena.config import ArenaConfig
from catch_arena.core.physics import WATCHDOG_MS
from catch_arena.messages import Twist
from catch_arena.ros.middleware.bus import Log, OnceLog
from catch_arena.ros.middleware.graph_names import ALIVE_TURTLES
from catch_arena.ros.middleware.interfaces import TwistMessage
from catch_arena.text import one_line
from catch_arena.verdicts import Ruling, Verdict

STANDING_STILL: Final = Twist(0.0, 0.0)
_FASTEST: Final = 1e9
"""Bound of the speeds and turn rates in a Twist, far above every limit of R2.5, which the arena applies later."""
_LOG_AT: Final = 10
"""Number of requests for targets that are gone after which the author gets a line."""


class RosSeat:
    """One hunter. Its node drives it until the node has been silent for as long as a Twist holds.

    `turtles` are the hunter's names on the bus. Under velocity control the arena requests the targets in reach (R4.4).
    """

    def __init__(self, config: ArenaConfig, seat: int, turtles: Sequence[str], player: str, log: Log) -> None:
        self.hunter, self.turtles, self.player = config.hunter_names[seat], turtles, player
        self.only_drives = config.controls[seat] == "velocity"
        self.state: Literal["new", "driven", "silent", "left"] = "new"
        """State: "new" until a node drives it, then "driven"; after that "left", or "silent" if no line was logged."""
        self._log, self._log_once = log, OnceLog(log)
        self._twist = STANDING_STILL
        self._twist_ms: int | None = -WATCHDOG_MS
        """Time of the last Twist [ms]; None if it came after the last step."""
        self._had_publishers = False
        """True if a node that could drive it was on the bus."""
        self._reach_m = config.reaches[seat]
        self._too_far_um: list[int] = []
        """Distances of its node's requests that were out of reach."""
        self._too_late = 0
        """Number of its node's requests for targets that were gone."""

    def on_twist(self, message: TwistMessage) -> None:
        """Take a Twist; the last one before a step counts."""
        speed, turn_rate = message.linear.x, message.angular.z
        if not (math.isfinite(speed) and math.isfinite(turn_rate)):
            self._log_once.warn(f"{self.hunter}: a Twist that is not finite is ignored")
            return
        if message.linear.y != 0.0:
            self._log_once.warn(f"{self.hunter}: its node sends linear.y, which turtles ignore: turn instead")
        if self.state in {"new", "left"}:
            self._log(f"{self.hunter}: its node {'is there' if self.state == 'new' else 'is back'}")
        self.state = "driven"
        self._twist = Twist(*(min(max(value, -_FASTEST), _FASTEST) for value in (speed, turn_rate)))
        self._twist_ms = None

    def command(self, now_ms: int, tick_ms: int, *, targets: bool) -> Twist:
        """R2.4: return the last Twist in each step, and zero at the first tick more than a second after it came.

        A Twist that came since the previous step counts from `now_ms`, the beginning of this one. Without `targets` to
        drive to, silence of a node is not logged.
        """
        if self._twist_ms is None:
            self._twist_ms = now_ms
        if tick_ms - self._twist_ms > WATCHDOG_MS:
            if self.state == "driven" and targets:
                self._leave("is silent")
            elif self.state == "driven":
                self.state = "silent"
            return STANDING_STILL
        return self._twist

    def look_for(self, publishers: int | None) -> None:
        """Log that its node has left, or that several may drive it; None stands for a bus that does not report it."""
        if publishers is None:
            return
        if self.state == "driven" and publishers > 1:
            self._log_once.warn(
                f"{self.hunter}: {publishers} nodes may drive it, and this bus does not report which one "
                "sends: all are obeyed",
                "two",
            )
        gone = self._had_publishers and not publishers
        if gone and self.state == "new":
            self._log(f"{self.hunter}: its node has gone, and never drove: look for an error in its terminal")
        elif not publishers and (self.state == "driven" or (gone and self.state == "silent")):
            self._leave("has gone")
        self._had_publishers = bool(publishers)

    def note(self, ruling: Ruling, requested: Collection[str]) -> None:
        """Note the ruling on a request of its node, which requested these targets in the step; log advice once."""
        if ruling.verdict is Verdict.OUT_OF_REACH and ruling.distance_um is not None:
            self._too_far_um.append(ruling.distance_um)
        elif ruling.verdict is Verdict.DUPLICATE and len(requested) > 1:
            hint = "only the first request of a step can be granted (R5.2): request one target within reach"
            self._log_once(f"{self.hunter} requested several targets in one step; {hint}", "several")
        elif ruling.verdict in {Verdict.ALREADY_CAUGHT, Verdict.UNKNOWN_TARGET}:
            self._too_late += 1
            if self._too_late == _LOG_AT:
                target = one_line(str(ruling.target)[:40])
                self._log(
                    f"{self.player} has requested targets that are gone {_LOG_AT} times, such as {target}: "
                    f"choose another target when yours leaves {ALIVE_TURTLES}"
                )

    def remarks(self) -> Iterator[str]:
        """Yield lines for the author of its node, to print after the ranking."""
        if self._too_far_um:
            near, far = min(self._too_far_um) / 1e6, max(self._too_far_um) / 1e6
            times = "1 request" if len(self._too_far_um) == 1 else f"{len(self._too_far_um)} requests"
            yield (
                f"{self.player}: {times} from too far, {near:.2f} to {far:.2f} m away: "
                f"a catch needs less than reach_m, {self._reach_m:g} m"
            )
        if self.state == "new":
            yield f"{self.player}: no node drove {self.hunter}: look for an error in its terminal"

    def stop(self) -> None:
        """Stand still until the next Twist."""
        self._twist, self._twist_ms = STANDING_STILL, -WATCHDOG_MS

    def _leave(self, reason: str) -> None:
        self.state = "left"
        self.stop()
        self._log(f"{self.hunter}: its node {reason}; the hunter stands still until a node drives it again")
