"""The exercise's turtle_spawner with our arbiter: it spawns targets in turtlesim and publishes which of them are alive.

It answers /catch_turtle by the rules of chapter 5.
"""

import math
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from random import Random
from typing import Any, Final

from catch_arena.arbitration import arbitrate
from catch_arena.config import ArenaConfig
from catch_arena.core.physics import DT, TICK_MS
from catch_arena.messages import CatchTurtleResponse, Pose, Turtle, TurtleArray
from catch_arena.ros.middleware.bus import Bus, Log, OnceLog, Request
from catch_arena.ros.middleware.graph_names import ALIVE_TURTLES, CATCH_TURTLE, KILL, SPAWN, catch_turtle_of, pose_of
from catch_arena.ros.middleware.interfaces import Interfaces, Name, SpawnRequest

_LOW_M, _HIGH_M = 0.5, 10.5
"""R3.2: range of the coordinates at which targets appear [m]."""
_SECOND: Final = 1000 // TICK_MS
"""Period in which the list of targets is published again [ticks]."""
_ANSWER_TICKS: Final = 125
"""Time after which a call of /spawn without an answer is given up [ticks]."""


class Spawner:
    """Referee of one turtlesim, with these hunters; if another node answers /catch_turtle, it only spawns.

    Of `config` it uses the spawn timer (R3.1), the prefix of names and the reach (R5.3).
    """

    def __init__(
        self,
        bus: Bus,
        turtles: tuple[str, ...],
        interfaces: Interfaces,
        config: ArenaConfig,
        *,
        seed: int,
        log: Log,
    ) -> None:
        self._bus, self._turtles, self._interfaces, self._log = bus, turtles, interfaces, log
        self._log_once = OnceLog(log)
        self._config = config
        self._period = max(1, round(config.spawn_period_ms / 1000.0 / DT))
        """Period of the spawn timer [ticks]."""
        self._seed, self._places = seed, Random(seed)
        self._has_begun = False
        self._ticks = self._fired = 0
        """The current tick, and the tick of the timer's last firing."""
        self._number = 0
        """Number of the last name that was tried."""
        self._spawning: tuple[Future[Name], SpawnRequest, int] | None = None
        """The call of /spawn that is not answered yet, its request and its tick; None if there is none."""
        self._poses: dict[str, Pose] = {}
        """The last pose of each hunter, by its name in turtlesim."""
        self._alive: dict[str, Turtle] = {}
        self._caught: set[str] = set()
        self._pending: list[tuple[int, Request]] = []
        self._spawn = bus.client(SPAWN, interfaces.spawn)
        self._kill = bus.client(KILL, interfaces.kill)
        self._referee = bus.client(CATCH_TURTLE, interfaces.catch_turtle)
        self._publish: Callable[[Any], None] = lambda _: None
        for turtle in turtles:
            bus.subscribe(pose_of(turtle), interfaces.pose, partial(self._on_pose, turtle))

    def tick(self) -> None:
        """Play 16 ms, once there is a turtlesim: judge the requests since the last tick together (R5.1)."""
        if not self._has_begun:
            if not (self._spawn.ready() and self._kill.ready()):
                return
            self._begin()
        self._ticks += 1
        self._read_spawned()
        if self._ticks >= self._fired + self._period and self._spawning is None:
            self._fired = self._ticks
            x, y = (self._places.uniform(_LOW_M, _HIGH_M) for _ in range(2))
            self._call_spawn(x, y, self._places.uniform(0.0, math.tau))
        if self._pending:
            self._judge()
        if self._ticks % _SECOND == 0:
            self._publish_alive()

    def _begin(self) -> None:
        """Start to answer catch requests, unless another node does."""
        self._has_begun = True
        if self._bus.backend != "rosbridge" and self._referee.ready():  # rosbridge does not report services
            self._log(f"another node serves {CATCH_TURTLE}: this node only spawns targets")
            return
        self._publish = self._bus.publisher(ALIVE_TURTLES, self._interfaces.turtle_array)
        services = [(catch_turtle_of(turtle), seat) for seat, turtle in enumerate(self._turtles)]
        if len(self._turtles) == 1:
            services.append((CATCH_TURTLE, 0))
        for service, seat in services:
            self._bus.serve(service, self._interfaces.catch_turtle, partial(self._on_catch_turtle, seat))

    def _on_pose(self, turtle: str, pose: Pose) -> None:
        if all(map(math.isfinite, pose)):
            self._poses[turtle] = pose

    def _on_catch_turtle(self, seat: int, request: Request) -> None:
        if self._turtles[seat] in self._poses:
            self._pending.append((seat, request))
        else:  # a turtle without a pose does not exist
            request.answer(CatchTurtleResponse(success=False))

    def _call_spawn(self, x: float, y: float, theta: float) -> None:
        self._number += 1
        request = SpawnRequest(x, y, theta, self._config.target_name(self._number))
        self._spawning = self._spawn.call(request), request, self._ticks

    def _read_spawned(self) -> None:
        """Read the answer of /spawn. An empty name means that the name was taken, as by an earlier spawner."""
        if self._spawning is None:
            return
        call, request, since = self._spawning
        if not call.done():
            if self._ticks > since + _ANSWER_TICKS:
                self._spawning = None
                self._log(f"warning: {SPAWN} does not answer")
            return
        self._spawning = None
        name = call.result().name
        if name:
            self._alive[name] = Turtle(name, request.x, request.y, request.theta)
            self._publish_alive()
            return
        self._log_once.warn(
            f"{request.name} is not spawned, because turtlesim has a turtle of that name: higher numbers are tried. "
            "--ros-args -p turtle_name_prefix:=NAME gives other names, and turtlesim's /reset removes all targets",
            "taken",
        )
        self._call_spawn(request.x, request.y, request.theta)

    def _judge(self) -> None:
        pending, self._pending = self._pending, []
        seen = [seat for seat, turtle in enumerate(self._turtles) if turtle in self._poses]
        hunters = [self._poses[self._turtles[seat]] for seat in seen]
        rulings = arbitrate(
            hunters=[(pose.x, pose.y) for pose in hunters],
            targets={turtle.name: (turtle.x, turtle.y) for turtle in self._alive.values()},
            requests=[(seen.index(seat), request.message.name) for seat, request in pending],
            reach_m=self._config.reach_m,
            seed=self._seed,
            step=self._ticks,
            caught=self._caught,
        )
        for (seat, request), ruling in zip(pending, rulings, strict=True):
            request.answer(CatchTurtleResponse(ruling.success))
            self._log(str(ruling).replace(f"hunter_{ruling.hunter}", self._turtles[seat], 1))
            if ruling.success:
                name = request.message.name
                del self._alive[name]
                self._caught.add(name)
                self._kill.call(Name(name))
                self._publish_alive()

    def _publish_alive(self) -> None:
        self._publish(TurtleArray(tuple(self._alive.values())))
