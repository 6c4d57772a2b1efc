"""The exercise's turtle_controller, with an agent as its driver: it hears one turtle's pose and the list of targets,
drives the turtle, and asks /catch_turtle.
"""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

import numpy as np

from catch_arena.config import ArenaConfig, Gains
from catch_arena.engine import Engine
from catch_arena.envs.spaces import checked_action
from catch_arena.errors import ActionError, AgentError
from catch_arena.messages import CatchTurtleRequest, Pose, TurtleArray
from catch_arena.policy import Limits
from catch_arena.ros.middleware.bus import Bus, Call, Log, Peer
from catch_arena.ros.middleware.graph_names import ALIVE_TURTLES, CATCH_TURTLE, catch_turtle_of, cmd_vel_of, pose_of
from catch_arena.ros.middleware.interfaces import TWIST, Interfaces, TwistMessage
from catch_arena.ros.middleware.parameters import Parameter
from catch_arena.tournament.players import Players
from catch_arena.tournament.secret import agent_seed
from catch_arena.world import World

PERIOD_S: Final = 0.1
"""R1.3: the exercise's control loop runs at 10 Hz."""
_ANSWER_S: Final = 1.0
"""After so long a request that was not answered is made again."""
_SILENT_S: Final = 1.0
"""A turtle whose pose is so old is not there any more."""
_ALONE: Final[dict[str, Any]] = {
    "hunters": 1,
    "initial_targets": 0,
    "max_targets": 64,
    "policy": "nearest",
    "gains": Gains(kp_v=2.0, ki_v=0.0, kp_w=6.0, ki_w=0.0),
    "control_period_ms": 100,
}


class Controller:
    """Drives one turtle by what an agent decides.

    The agent sees a position of an arena of its own, into which the turtle and the targets are put anew each time, and
    no rivals. Its hosted controller has the exercise's gains.

    Args:
        bus: the bus.
        players: the agent, in seat 0; with `closest_first` nearest is there, and first in seat 1.
        config: reach and limits of the turtle; the rest is the exercise's.
        turtle: its name.
        interfaces: the packages of the types.
        closest_first: which of two agents drives, from one control period to the next; None where there is one.
        service: which is asked for catches; None asks the turtle's own, as /turtle1/catch_turtle, where somebody serves
            it, and else /catch_turtle.
        log: takes one line when there is news.
    """

    def __init__(
        self,
        bus: Bus,
        players: Players,
        config: ArenaConfig,
        turtle: str,
        interfaces: Interfaces,
        closest_first: Parameter | None = None,
        *,
        service: str | None = None,
        log: Log,
    ) -> None:
        config = config.replace(**_ALONE, control=players.controls[0], observed_targets=64)
        self._engine = Engine(config)
        self._players, self._closest_first = players, closest_first
        self._turtle, self._log = turtle, log
        self._pose: Pose | None = None
        self._heard_s = -_SILENT_S
        self._turtles = TurtleArray(())
        self._calls: dict[str, tuple[Call, float]] = {}
        self._known: dict[str, float] = {}
        self._warned = self._unserved = False
        self.caught = 0
        """How often /catch_turtle said yes."""
        self._cmd_vel: Callable[[TwistMessage], None] = bus.publisher(cmd_vel_of(turtle), TWIST)
        self._services = [CATCH_TURTLE] if service is None else [service]
        if service is None and bus.backend != "rosbridge":  # which does not tell who serves what
            self._services.insert(0, catch_turtle_of(turtle))
        self._clients = [bus.client(name, interfaces.catch_turtle) for name in self._services]
        bus.subscribe(pose_of(turtle), interfaces.pose, self._on_pose)
        bus.subscribe(ALIVE_TURTLES, interfaces.turtle_array, self._on_turtles)
        self._engine.reset([0])
        limits = replace(Limits.of(config), control_period_ms=config.control_period_ms)
        seats = range(len(players.controls))
        for fault in players.reset([agent_seed(0, seat) for seat in seats], [limits for _ in seats]).values():
            raise AgentError(fault.reason)

    def tick(self) -> None:
        """R1.3: one control period.

        Raises:
            AgentError: where the agent fails.
        """
        self._read_answers()
        if self._pose is None:
            return
        if time.monotonic() > self._heard_s + _SILENT_S:
            self._pose = None
            self._log(f"{self._turtle} is silent: no pose for {_SILENT_S:g} s")
            return
        world, names = self._put(self._pose)
        self._decide()
        after = self._engine.world()
        (hunter,) = after.hunters
        self._cmd_vel(TwistMessage.of(hunter.linear_velocity, hunter.angular_velocity))
        for ruling in after.rulings:
            if ruling.success:  # within reach: now ask those who know
                self._request_catch(names[[target.name for target in world.targets].index(str(ruling.target))])

    def stop(self) -> None:
        """The turtle stands still."""
        self._cmd_vel(TwistMessage.of(0.0, 0.0))

    def _on_pose(self, pose: Pose, peer: Peer | None) -> None:
        del peer
        if all(map(math.isfinite, pose)):
            if self._pose is None:
                self._log(f"{self._turtle} is there")
            self._pose, self._heard_s = pose, time.monotonic()

    def _on_turtles(self, turtles: TurtleArray, peer: Peer | None) -> None:
        del peer
        self._turtles = turtles

    def _put(self, pose: Pose) -> tuple[World, list[str]]:
        """The position as the agent sees it, and what its targets are really called. They are as old as it is long
        since each was first heard of; who is listed before another is older.
        """
        side, most = self._engine.config.side_m, self._engine.config.max_targets
        there = [
            turtle
            for turtle in self._turtles.turtles
            if -side <= turtle.x <= 2 * side and -side <= turtle.y <= 2 * side  # of garbage nothing can be made
        ][:most]
        if len(there) < min(len(self._turtles.turtles), most) and not self._warned:
            self._warned = True
            self._log(
                "warning: /alive_turtles has targets far outside: is your Turtle.msg of float32? "
                "(`catch-arena docs ros2`)"
            )
        now, names = time.monotonic(), [turtle.name for turtle in there]
        self._known = {name: self._known.get(name, now) for name in names}
        ages = [now - self._known[name] + 1e-3 * (len(names) - place) for place, name in enumerate(names)]
        targets = [(turtle.x, turtle.y) for turtle in there]
        self._engine.place(0, [(pose.x, pose.y, pose.theta)], targets, ages=ages)
        return self._engine.world(), names

    def _decide(self) -> None:
        """The agent's action, played for one step in its own arena: what its hunter does there the turtle does here."""
        config = self._engine.config
        control = config.controls[0]
        mask = [] if control == "velocity" else self._engine.masks[0, 0].tolist()
        seat = 0 if self._closest_first is None or self._closest_first.value else 1
        action, _, fault = self._players.act({seat: (self._engine.observations[0, 0].tolist(), mask)})[seat]
        if fault is not None:
            raise AgentError(f"{fault.code}: {fault.reason}")
        try:
            rank, command = checked_action(control, self._turtle, action, config.targets_seen)
        except ActionError as error:
            raise AgentError(f"FORFEIT_ILLEGAL: {error}") from None
        self._engine.step(np.array([[rank]], dtype=np.int64), np.array([[command]], dtype=np.float32))
        if self._engine.ends[0]:
            self._engine.reset([0])

    def _request_catch(self, name: str) -> None:
        now = time.monotonic()
        asked = self._calls.get(name)
        if asked is not None and now <= asked[1] + _ANSWER_S:
            return
        client = next((client for client in self._clients if client.ready), None)
        if client is not None:
            self._calls[name] = client.call(CatchTurtleRequest(name)), now
        elif not self._unserved:
            self._unserved = True
            self._log(f"warning: {name} is within reach, and nobody serves {' or '.join(self._services)}")

    def _read_answers(self) -> None:
        for name, (call, _) in list(self._calls.items()):
            if call.response is not None:
                del self._calls[name]
                if call.response.success:
                    self.caught += 1
                    self._log(f"caught {name}: {self.caught}")
                    rest = tuple(turtle for turtle in self._turtles.turtles if turtle.name != name)
                    self._turtles = TurtleArray(rest)  # the list without it may be late
