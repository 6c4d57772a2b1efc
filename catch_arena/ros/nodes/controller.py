"""The exercise's turtle_controller with an agent: it reads a turtle's pose and the list of targets, and drives.

It calls /catch_turtle for the targets within reach.
"""

import math
import time
from concurrent.futures import Future
from dataclasses import replace
from typing import Any, Final

import numpy as np

from catch_arena.config import ArenaConfig, Gains
from catch_arena.engine import Engine
from catch_arena.envs.actions import checked_action
from catch_arena.errors import ActionError, AgentError
from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse, Pose, Turtle, TurtleArray
from catch_arena.policy import Limits
from catch_arena.ros.middleware.bus import Bus, Log, OnceLog
from catch_arena.ros.middleware.graph_names import ALIVE_TURTLES, CATCH_TURTLE, catch_turtle_of, cmd_vel_of, pose_of
from catch_arena.ros.middleware.interfaces import TWIST, Interfaces, TwistMessage
from catch_arena.tournament.players import Players
from catch_arena.tournament.secret import agent_seed

PERIOD_S: Final = 0.1
"""R1.3: period of the exercise's control loop [s]."""
_ANSWER_S: Final = 1.0
"""Time after which a request without an answer is forgotten, so that it may be repeated [s]."""
_SETTINGS: Final[dict[str, Any]] = {
    "hunters": 1,
    "initial_targets": 0,
    "max_targets": 64,
    "policy": "nearest",
    "gains": Gains(kp_v=2.0, ki_v=0.0, kp_w=6.0, ki_w=0.0),
    "control_period_ms": 100,
}


class Controller:
    """Driver of one turtle by the decisions of an agent.

    The agent plays in an arena of its own, in which the turtle and the targets are placed in each period; it has no
    rivals. The arena's controller has the exercise's gains; of `config` only the turtle's reach and limits are used.

    It calls `service`; None is the turtle's own, /turtle1/catch_turtle, if it is served, else /catch_turtle.
    """

    def __init__(
        self,
        bus: Bus,
        players: Players,
        config: ArenaConfig,
        turtle: str,
        interfaces: Interfaces,
        *,
        service: str | None = None,
        log: Log,
    ) -> None:
        config = config.replace(**_SETTINGS, control=players.controls[0], observed_targets=64)
        self._engine = Engine(config)
        self._players, self._turtle, self._log = players, turtle, log
        self._pose: Pose | None = None
        self._targets: list[Turtle] = []
        self._listed_s: dict[str, float] = {}
        """Monotonic time at which each of the targets was first in the list [s]."""
        self._calls: dict[str, tuple[Future[CatchTurtleResponse], float]] = {}
        """Unanswered requests by target, each with its monotonic time [s]."""
        self._caught = 0
        self._log_once = OnceLog(log)
        self._cmd_vel = bus.publisher(cmd_vel_of(turtle), TWIST)
        self._services = [CATCH_TURTLE] if service is None else [service]
        if service is None and bus.backend != "rosbridge":  # rosbridge does not report services
            self._services.insert(0, catch_turtle_of(turtle))
        self._clients = [bus.client(name, interfaces.catch_turtle) for name in self._services]
        bus.subscribe(pose_of(turtle), interfaces.pose, self._on_pose)
        bus.subscribe(ALIVE_TURTLES, interfaces.turtle_array, self._on_turtles)
        self._engine.reset([0])
        limits = replace(Limits.of(config), control_period_ms=config.control_period_ms)
        for fault in players.reset([agent_seed(0, 0)], [limits]).values():
            raise AgentError(fault.reason)

    def tick(self) -> None:
        """R1.3: play one control period, or raise AgentError if the agent fails."""
        self._read_answers()
        if self._pose is None:
            return
        names = self._place(self._pose)
        self._decide()
        world = self._engine.world()
        (hunter,) = world.hunters
        self._cmd_vel(TwistMessage.of(hunter.linear_velocity, hunter.angular_velocity))
        for ruling in world.rulings:
            if ruling.success:  # the target is within reach: call the referee
                self._request_catch(names[str(ruling.target)])

    def stop(self) -> None:
        """Stop the turtle."""
        self._cmd_vel(TwistMessage.of(0.0, 0.0))

    def _on_pose(self, pose: Pose) -> None:
        if all(map(math.isfinite, pose)):
            if self._pose is None:
                self._log(f"{self._turtle} is there")
            self._pose = pose

    def _on_turtles(self, turtles: TurtleArray) -> None:
        self._targets = list(turtles.turtles)

    def _place(self, pose: Pose) -> dict[str, str]:
        """Place the turtle and its targets in the arena, and return the targets' names by their names in the arena.

        A target's age counts from its first list; of two that were new in one list the earlier one is older.
        """
        side, limit = self._engine.config.side_m, self._engine.config.max_targets
        near = [one for one in self._targets if -side <= one.x <= 2 * side and -side <= one.y <= 2 * side]
        if len(near) < len(self._targets):
            self._log_once.warn(
                "/alive_turtles has targets far outside: is your Turtle.msg of float32 (`catch-arena docs ros_names`)?",
                "places",
            )
        targets, now = near[:limit], time.monotonic()
        self._listed_s = {one.name: self._listed_s.get(one.name, now) for one in targets}
        ages = [now - self._listed_s[one.name] + 1e-3 * (len(targets) - place) for place, one in enumerate(targets)]
        self._engine.place(0, [(pose.x, pose.y, pose.theta)], [(one.x, one.y) for one in targets], ages=ages)
        placed = self._engine.world().targets
        return {here.name: one.name for here, one in zip(placed, targets, strict=True)}

    def _decide(self) -> None:
        """Play the agent's action for one step in its own arena; the turtle then does what the hunter does there."""
        config = self._engine.config
        control = config.controls[0]
        mask = [] if control == "velocity" else self._engine.masks[0, 0].tolist()
        action, _, fault = self._players.act({0: (self._engine.observations[0, 0].tolist(), mask)})[0]
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
        if name in self._calls:
            return
        client = next((client for client in self._clients if client.ready()), None)
        if client is not None:
            self._calls[name] = client.call(CatchTurtleRequest(name)), time.monotonic()
        else:
            self._log_once.warn(f"{name} is within reach, but no node serves {' or '.join(self._services)}", "service")

    def _read_answers(self) -> None:
        for name, (call, since) in list(self._calls.items()):
            if call.done():
                del self._calls[name]
                if call.result().success:
                    self._caught += 1
                    self._log(f"caught {name}: {self._caught}")
                    self._targets = [one for one in self._targets if one.name != name]  # the next list may be late
            elif time.monotonic() > since + _ANSWER_S:
                del self._calls[name]
