"""Checks of other nodes that would disturb the arena or a player: each problem is logged once, with a command."""

from collections.abc import Collection, Iterator, Sequence
from typing import Final

from catch_arena.ros.middleware.bus import Endpoint, Log, OnceLog
from catch_arena.ros.middleware.graph_names import (
    ALIVE_TURTLES,
    CATCH_TURTLE,
    POSE,
    SPAWN,
    TURTLE,
    catch_turtle_of,
    cmd_vel_of,
    pose_of,
)
from catch_arena.ros.middleware.interfaces import TWIST, Interfaces

RUN: Final = "ros2 run YOUR_PACKAGE YOUR_CONTROLLER"


def run_line(hunter: str, *, shared: bool) -> str:
    """Return the command that starts the exercise's controller for one hunter.

    If several seats are `shared` among nodes, each node needs a remapping to its own hunter.
    """
    return f"{RUN} {remapping_to(hunter)}" if shared else RUN


def remapping_to(hunter: str) -> str:
    """Return the arguments with which a node of the exercise drives one hunter and requests catches for it."""
    names = [
        (cmd_vel_of(TURTLE), cmd_vel_of(hunter)),
        (pose_of(TURTLE), pose_of(hunter)),
        (CATCH_TURTLE, catch_turtle_of(hunter)),
    ]
    return f"--ros-args {_remapped(names)}"


class Neighbours:
    """Checker of the bus's graph; `driven` are the names of the hunters that nodes drive."""

    def __init__(self, hunters: Sequence[str], driven: Collection[str], interfaces: Interfaces, log: Log) -> None:
        self._driven, self._interfaces, self._log_once = sorted(driven), interfaces, OnceLog(log)
        self._cmd_vels = {cmd_vel_of(one) for one in (*hunters, TURTLE)}
        self._published = {pose_of(one) for one in (*hunters, TURTLE)} | {ALIVE_TURTLES}
        services = {catch_turtle_of(one) for one in driven} | {CATCH_TURTLE, SPAWN}
        self._own = self._published | self._cmd_vels | services
        self._proposed = self._driven[0] if len(self._driven) > 1 else TURTLE
        """The hunter that a node with other names is to drive."""
        self.seen: tuple[str, ...] = ()
        """Names of the nodes that were on the bus in the last `look`."""
        self._served: dict[str, str] = {}
        """Names that `look` has returned, with the usual ones."""

    def look(self, graph: Sequence[Endpoint], free: Sequence[str] = ()) -> dict[str, str]:
        """Log new problems, and return the new names that the arena is to serve like the usual ones.

        A name of the list or of the catch service is returned if there is one seat for a node, and if the node needs no
        other remapping: a client that is created for each call appears with the first call, too late for a remapping.
        A remapping proposes the first of the hunters in `free`, which no node drives yet.
        """
        before = dict(self._served)
        if len(self._driven) > 1:
            self._proposed = next(iter(free), self._driven[0])
        self.seen = tuple(sorted({one.node for one in graph}))
        provided = {one.name for one in graph if one.kind in {"publisher", "service"}} | self._own
        for node in self.seen:
            own = [one for one in graph if one.node == node]
            for line in (*self._referees(node, own), *self._other_types(node, own)):
                self._log_once.warn(line, line.partition(":")[0])  # the proposed hunter changes
            remapped = dict(self._other_names(own, provided))
            if len(self._driven) == 1 and set(remapped.values()) <= {ALIVE_TURTLES, CATCH_TURTLE}:
                self._served |= remapped
            elif remapped:
                names = " and ".join(remapped)
                self._log_once.warn(
                    f"{node} uses {names}, which no node serves here: start it with --ros-args "
                    f"{_remapped(list(remapped.items()))}",
                    f"{node} uses {names}",
                )
        return {name: usual for name, usual in self._served.items() if name not in before}

    def _referees(self, node: str, own: Sequence[Endpoint]) -> Iterator[str]:
        uses = [f"publishes {end.name}" for end in own if end.kind == "publisher" and end.name in self._published]
        uses += [f"serves {end.name}" for end in own if end.kind == "service" and end.name in {CATCH_TURTLE, SPAWN}]
        if uses:
            guess = "turtlesim or a second arena" if any(SPAWN in use or POSE in use for use in uses) else "a spawner"
            yield (
                f"{node} {' and '.join(uses)}, as the arena does: two referees in one domain. It looks like {guess}: "
                f"end it, and start your controller alone: {run_line(self._proposed, shared=len(self._driven) > 1)}"
            )

    def _other_types(self, node: str, own: Sequence[Endpoint]) -> Iterator[str]:
        ours = {ALIVE_TURTLES: self._interfaces.turtle_array.name, CATCH_TURTLE: self._interfaces.catch_turtle.name}
        for one in own:
            package = one.type.partition("/")[0]
            differs = one.type != ours.get(one.name, one.type) and one.kind in {"subscription", "client"}
            if differs and package != self._interfaces.package:
                yield (
                    f"{node} has {one.type} for {one.name}, and the arena has {ours[one.name]}: they cannot exchange "
                    f"messages. Start the arena again with --interfaces {package}"
                )
            elif one.name in self._own and one.fields_differ:
                yield (
                    f"{node} has other fields in {one.type} than the arena, on {one.name}: messages are lost, or have "
                    f"wrong numbers. Source the same {package} in both terminals"
                )

    def _other_names(self, own: Sequence[Endpoint], provided: Collection[str]) -> Iterator[tuple[str, str]]:
        """Yield the names that a node uses in the place of the arena's, each with the arena's."""
        hunter = self._proposed
        catch = catch_turtle_of(hunter) if len(self._driven) > 1 else CATCH_TURTLE
        for one in own:
            if one.kind == "publisher" and one.type == TWIST.name:
                if one.name.endswith("/cmd_vel") and one.name not in self._cmd_vels:
                    yield one.name, cmd_vel_of(hunter)
            elif one.kind == "subscription" and one.name not in provided:
                if one.type == self._interfaces.turtle_array.name:
                    yield one.name, ALIVE_TURTLES
                elif one.type == self._interfaces.pose.name:
                    yield one.name, pose_of(hunter)
            elif one.kind == "client" and one.name not in provided and one.type == self._interfaces.catch_turtle.name:
                yield one.name, catch


def _remapped(names: Sequence[tuple[str, str]]) -> str:
    return " ".join(f"-r {name}:={own}" for name, own in names)
