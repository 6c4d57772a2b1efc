"""The exercise's turtle_spawner, with our arbiter: it spawns targets in turtlesim, publishes which are alive, and
answers /catch_turtle by the rules of chapter 5.
"""

import math
from collections.abc import Callable
from random import Random
from typing import Any, Final

from catch_arena.arbitration import arbitrate
from catch_arena.config import ArenaConfig
from catch_arena.core.physics import DT, TICK_MS
from catch_arena.messages import CatchTurtleResponse, Pose, Turtle, TurtleArray
from catch_arena.ros.middleware.bus import Bus, Call, Log, Peer, Request
from catch_arena.ros.middleware.graph_names import ALIVE_TURTLES, CATCH_TURTLE, KILL, SPAWN, catch_turtle_of, pose_of
from catch_arena.ros.middleware.interfaces import Interfaces, Name, SpawnRequest
from catch_arena.ros.middleware.parameters import Parameter

_LOW_M, _HIGH_M = 0.5, 10.5
"""R3.2: where targets appear."""
_SECOND: Final = 1000 // TICK_MS
"""In ticks."""
_ANSWER_TICKS: Final = 125
"""After so many a call that was not answered is given up."""
_NAMES_AT_ONCE: Final = 64
"""So many names are tried at one firing of the timer."""
_SILENT_TICKS: Final = 250 // TICK_MS
"""A target that has told its pose and is silent for so long, while others tell theirs, is gone."""
_NOBODY: Final = CatchTurtleResponse(success=False)


class Spawner:
    """Referees one turtlesim; where /catch_turtle is answered already, it spawns and does no more.

    Args:
        bus: the bus.
        turtles: the hunters' names in turtlesim.
        interfaces: the packages of the types.
        config: of which the names' prefix and the reach (R5.3) are read.
        spawn_frequency: of the spawn timer (R3.1); a new value counts from the last target on.
        seed: of the places.
        log: takes one line when there is news.
    """

    def __init__(
        self,
        bus: Bus,
        turtles: tuple[str, ...],
        interfaces: Interfaces,
        config: ArenaConfig,
        spawn_frequency: Parameter,
        *,
        seed: int,
        log: Log,
    ) -> None:
        self._bus, self._turtles, self._interfaces, self._log = bus, turtles, interfaces, log
        self._config, self._frequency = config, spawn_frequency
        self._fired = 0
        self._places = Random(seed)
        self._seed = seed
        self._poses: dict[str, Pose] = {}
        self._hunter_heard = 0
        """The tick in which a hunter told its pose last."""
        self._alive: dict[str, Turtle] = {}
        self._heard: dict[str, int] = {}
        """The tick in which each target that was heard of told its pose last."""
        self._refused = 0
        """How many names were taken, one after the other."""
        self._warned = False
        self._caught: set[str] = set()
        self._pending: list[tuple[int, Request]] = []
        self._number = self._ticks = 0
        self._spawning: tuple[Call, SpawnRequest, int] | None = None
        self.scores = [0] * len(turtles)
        self._spawn = bus.client(SPAWN, interfaces.spawn)
        self._kill = bus.client(KILL, interfaces.kill)
        self._referee = bus.client(CATCH_TURTLE, interfaces.catch_turtle)
        self._publish: Callable[[Any], None] | None = None
        for turtle in turtles:
            bus.subscribe(pose_of(turtle), interfaces.pose, self._pose_callback(turtle))

    @property
    def ready(self) -> bool:
        """Whether there is a turtlesim."""
        return self._spawn.ready and self._kill.ready

    def begin(self) -> None:
        """Referee, unless somebody does."""
        if self._bus.backend != "rosbridge" and self._referee.ready:  # rosbridge does not tell
            self._log(f"{CATCH_TURTLE} is answered already: this node spawns, and no more")
            return
        self._publish = self._bus.publisher(ALIVE_TURTLES, self._interfaces.turtle_array)
        for seat, turtle in enumerate(self._turtles):
            self._bus.serve(catch_turtle_of(turtle), self._interfaces.catch_turtle, self._catch_turtle_callback(seat))
        if len(self._turtles) == 1:
            self._bus.serve(CATCH_TURTLE, self._interfaces.catch_turtle, self._catch_turtle_callback(0))

    def tick(self) -> None:
        """16 ms: what was asked meanwhile is judged together (R5.1)."""
        self._ticks += 1
        self._read_spawned()
        if self._frequency.value != self._config.spawn_frequency_hz:
            self._config = self._config.replace(spawn_frequency_hz=self._frequency.value)
            self._log(f"{self._frequency.name}: {self._frequency.value:g}")
        if self._ticks >= self._fired + self._period and self._spawning is None:
            self._fired = self._ticks
            x, y = (self._places.uniform(_LOW_M, _HIGH_M) for _ in range(2))
            self._call_spawn(x, y, self._places.uniform(0.0, math.tau))
        self._drop_ghosts()
        if self._pending:
            self._judge()
        if self._ticks % _SECOND == 0:
            self._publish_alive()

    @property
    def _period(self) -> int:
        """In ticks."""
        return max(1, round(self._config.spawn_period_ms / 1000.0 / DT))

    def _pose_callback(self, turtle: str) -> Callable[[Pose, Peer | None], None]:
        def callback(pose: Pose, peer: Peer | None) -> None:
            del peer
            if all(map(math.isfinite, pose)):
                self._poses[turtle] = pose
                self._hunter_heard = self._ticks

        return callback

    def _catch_turtle_callback(self, seat: int) -> Callable[[Request], None]:
        return lambda request: self._pending.append((seat, request))

    def _call_spawn(self, x: float, y: float, theta: float) -> None:
        self._number += 1
        asked = SpawnRequest(x, y, theta, self._config.target_name(self._number))
        self._spawning = self._spawn.call(asked), asked, self._ticks

    def _try_next_name(self, asked: SpawnRequest) -> None:
        """Nothing was spawned: in turtlesim the name was taken, as by a spawner that ran before this one."""
        if not self._warned:
            self._warned = True
            self._log(
                f"warning: {asked.name} is not spawned, as turtlesim has one of that name: higher numbers are tried. "
                "--name-prefix gives other names, and turtlesim's /reset removes all targets"
            )
        self._refused += 1
        if self._refused % _NAMES_AT_ONCE:
            self._call_spawn(asked.x, asked.y, asked.theta)

    def _read_spawned(self) -> None:
        if self._spawning is None:
            return
        call, asked, since = self._spawning
        if call.response is not None:
            self._spawning = None
            name = call.response.name
            if not name:
                self._try_next_name(asked)
                return
            self._refused = 0
            self._alive[name] = Turtle(name, asked.x, asked.y, asked.theta)
            self._bus.subscribe(pose_of(name), self._interfaces.pose, self._target_callback(name))
            self._publish_alive()
        elif self._ticks > since + _ANSWER_TICKS:
            self._spawning = None
            self._log(f"warning: {SPAWN} does not answer")

    def _target_callback(self, name: str) -> Callable[[Pose, Peer | None], None]:
        def callback(pose: Pose, peer: Peer | None) -> None:
            del pose, peer
            if name in self._alive:
                self._heard[name] = self._ticks

        return callback

    def _drop_ghosts(self) -> None:
        """Take targets off the list that turtlesim has no more, as after its /reset: they are silent, and others are
        not.
        """
        last = max((self._hunter_heard, *self._heard.values()))
        ghosts = [name for name, tick in self._heard.items() if last >= tick + _SILENT_TICKS]
        if ghosts:
            others = f" and {len(ghosts) - 1} more are" if len(ghosts) > 1 else " is"
            self._log(f"{ghosts[0]}{others} not in turtlesim any more")
            for name in ghosts:
                self._forget(name)
            self._publish_alive()

    def _forget(self, name: str) -> None:
        del self._alive[name]
        self._heard.pop(name, None)
        self._bus.unsubscribe(pose_of(name))

    def _judge(self) -> None:
        asked, self._pending = self._pending, []
        seen = [seat for seat, turtle in enumerate(self._turtles) if turtle in self._poses]
        hunters = [self._poses[self._turtles[seat]] for seat in seen]
        known = [(seat, request) for seat, request in asked if seat in seen]
        rulings = arbitrate(
            hunters=[(pose.x, pose.y) for pose in hunters],
            targets={turtle.name: (turtle.x, turtle.y) for turtle in self._alive.values()},
            requests=[(seen.index(seat), request.message.name) for seat, request in known],
            reach_m=self._config.reach_m,
            seed=self._seed,
            step=self._ticks,
            caught=self._caught,
        )
        for seat, request in asked:
            if seat not in seen:  # a turtle without a pose is not there
                request.answer(_NOBODY)
        for (seat, request), ruling in zip(known, rulings, strict=True):
            request.answer(CatchTurtleResponse(ruling.success))
            self._log(str(ruling).replace(f"hunter_{ruling.hunter}", self._turtles[seat], 1))
            if ruling.success:
                name = request.message.name
                self._forget(name)
                self._caught.add(name)
                self.scores[seat] += 1
                self._kill.call(Name(name))
                self._publish_alive()

    def _publish_alive(self) -> None:
        if self._publish is not None:
            self._publish(TurtleArray(tuple(self._alive.values())))
