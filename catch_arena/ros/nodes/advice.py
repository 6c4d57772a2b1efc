"""Advice for the authors of nodes: mistakes of their nodes, and commands that correct them. Each is logged once."""

from collections.abc import Collection, Sequence
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.ros.middleware import graph_names
from catch_arena.ros.middleware.bus import Log, OnceLog
from catch_arena.ros.nodes.neighbours import remapping_to
from catch_arena.text import one_line
from catch_arena.verdicts import Ruling, Verdict

_LOG_AT: Final = 10
"""Number of requests for targets that are gone after which the author gets a line."""


class Advice:
    """Collector of the advice in one match.

    Args:
        config: the arena's settings.
        names: the players' names, by seat.
        log: takes one line for each new advice.
    """

    def __init__(self, config: ArenaConfig, names: Sequence[str], log: Log) -> None:
        self._reaches = dict(zip(config.hunter_names, config.reaches, strict=True))
        self._names = dict(zip(config.hunter_names, names, strict=True))
        self._log, self._log_once = log, OnceLog(log)
        self._too_far: dict[str, list[int]] = {hunter: [] for hunter in config.hunter_names}
        """Distances of a hunter's requests that were out of reach [um]."""
        self._too_late = dict.fromkeys(config.hunter_names, 0)
        """Number of a hunter's requests for targets that were gone."""

    def note(self, hunter: str, ruling: Ruling, requested: Collection[str]) -> None:
        """Note the ruling on a node's request.

        Args:
            hunter: the hunter of the request.
            ruling: the ruling.
            requested: the targets that this hunter requested in this step.
        """
        if ruling.verdict is Verdict.OUT_OF_REACH and ruling.distance_um is not None:
            self._too_far[hunter].append(ruling.distance_um)
        elif ruling.verdict is Verdict.DUPLICATE and len(requested) > 1:
            hint = "only the first request of a step can be granted (R5.2): request one target within reach"
            self._log_once(f"{hunter} requested several targets in one step; {hint}", f"{hunter} several")
        elif ruling.verdict in {Verdict.ALREADY_CAUGHT, Verdict.UNKNOWN_TARGET}:
            self._too_late[hunter] += 1
            if self._too_late[hunter] == _LOG_AT:
                target = one_line(str(ruling.target)[:40])
                self._log(
                    f"{self._names[hunter]} has requested targets that are gone {_LOG_AT} times, such as {target}: "
                    f"choose another target when yours leaves {graph_names.ALIVE_TURTLES}"
                )

    def explain_remapping(self, free: Sequence[str]) -> None:
        """Log how a node that drives turtle1 becomes one of the hunters that no node drives."""
        first, *further = (f"{hunter} ({self._names[hunter]})" for hunter in free)
        also = f"; in the same way for {', '.join(further)}" if further else ""
        self._log(
            f"warning: a node drives {graph_names.TURTLE}, but no hunter has that name if several seats are for "
            f"nodes: start it with {remapping_to(free[0])} to drive {first}{also}"
        )

    def remarks(self) -> tuple[str, ...]:
        """Return a line for each player whose requests came from too far away."""
        lines = []
        for hunter, distances in self._too_far.items():
            if distances:
                near, far = min(distances) / 1e6, max(distances) / 1e6
                times = "1 request" if len(distances) == 1 else f"{len(distances)} requests"
                lines.append(
                    f"{self._names[hunter]}: {times} from too far, {near:.2f} to {far:.2f} m away: "
                    f"a catch needs less than reach_m, {self._reaches[hunter]:g} m"
                )
        return tuple(lines)
