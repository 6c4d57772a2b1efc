"""The arena as a node of a ROS 2 bus, with the parts of turtlesim, of the exercise's spawner and of the arbiter."""

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from typing import Any, Final

from catch_arena.core.physics import TICK_MS
from catch_arena.errors import ActionError, BusError, EpisodeError
from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse, TurtleArray
from catch_arena.ros.arena_service import ArenaService
from catch_arena.ros.middleware import graph_names
from catch_arena.ros.middleware.bus import Bus, Log, OnceLog, Request
from catch_arena.ros.middleware.interfaces import (
    CLOCK,
    EMPTY,
    RULING,
    STANDING,
    TWIST,
    Clock,
    Empty,
    Interfaces,
    MessageType,
    Name,
    RulingMessage,
    SpawnRequest,
    StandingMessage,
    Time,
)
from catch_arena.ros.nodes.agents import AgentSeats
from catch_arena.ros.nodes.neighbours import Neighbours, remapping_to, run_line
from catch_arena.ros.nodes.seats import RosSeat
from catch_arena.tournament.match import ranks_of
from catch_arena.world import World

_SECOND: Final = 1000 // TICK_MS
"""Period in which everything is published again for new listeners [ticks]."""
_OFTEN: Final = 6
"""Period in which moving targets are published, and nodes that have gone are found [ticks]."""
_MOST_JUDGED: Final = 4
"""R8.4: the most requests of one hunter that are judged in one step. Only the first can be granted, and all clients of
a shared service get all answers, in a queue of ten.
"""
_HELD: Final = 10
"""Time in which a new node gets its pose before the list of targets [ticks]: many solutions need the pose first."""
_EXERCISE_CMD_VEL: Final = graph_names.cmd_vel_of(graph_names.TURTLE)
_REFUSED: Final = CatchTurtleResponse(success=False)
"""Answer to a request that is not judged."""


class ArenaNode:
    """The arena, played tick by tick with the nodes on the bus, which drive the seats `driven`.

    The control period of the service is TICK_MS, the tick of turtlesim (R1.2). `names` are the players' names by seat.
    If `clock` is true, the arena's time is published on /clock.
    """

    def __init__(
        self,
        bus: Bus,
        service: ArenaService,
        driven: Collection[int],
        names: Sequence[str],
        agents: AgentSeats,
        interfaces: Interfaces,
        *,
        clock: bool,
        log: Log,
    ) -> None:
        self._bus, self._service, self._agents, self._interfaces, self._log = bus, service, agents, interfaces, log
        config, self._names = service.config, names
        turtles = [[hunter] for hunter in config.hunter_names]
        """Names of each hunter on the bus, by seat."""
        if len(driven) == 1:
            (only,) = driven
            turtles[only].append(graph_names.TURTLE)
        elif driven:  # no hunter is called turtle1 here
            bus.subscribe(_EXERCISE_CMD_VEL, TWIST, lambda _: self._explain_remapping())
        self.seats = [RosSeat(config, seat, turtles[seat], names[seat], log) for seat in sorted(driven)]
        self._log_once = OnceLog(log)
        self._neighbours = Neighbours(config.hunter_names, [seat.hunter for seat in self.seats], interfaces, log)
        self._remapping_explained = False
        """True if the advice on remapping a node that drives turtle1 was logged."""
        self._pending: list[tuple[RosSeat, Request]] = []
        """Catch requests for the next step."""
        self._ticks = 0
        self._list_from = 0
        """The first tick in which the list of targets may be published."""
        self._standing: tuple[tuple[int, ...], bool] = (), False
        """The scores, and whether the match has ended, in the last standings."""
        self._watched = [graph_names.pose_of(turtle) for seat in self.seats for turtle in seat.turtles]
        """Topics whose new listeners are new nodes."""
        self._poses = [[bus.publisher(graph_names.pose_of(one), interfaces.pose) for one in own] for own in turtles]
        self._lists = [bus.publisher(graph_names.ALIVE_TURTLES, interfaces.turtle_array)]
        self._rulings = self._optional_publisher(graph_names.RULINGS, RULING)
        self._standings = self._optional_publisher(graph_names.STANDINGS, STANDING)
        self._clock = bus.publisher(graph_names.CLOCK, CLOCK) if clock else None
        drawing = {graph_names.CLEAR: EMPTY}
        for seat in self.seats:
            for turtle in seat.turtles:
                bus.subscribe(graph_names.cmd_vel_of(turtle), TWIST, seat.on_twist)
                drawing[graph_names.set_pen_of(turtle)] = interfaces.set_pen
            bus.serve(graph_names.catch_turtle_of(seat.hunter), interfaces.catch_turtle, partial(self._ask, seat))
        bus.serve(graph_names.CATCH_TURTLE, interfaces.catch_turtle, self._on_catch_turtle)
        bus.serve(graph_names.SPAWN, interfaces.spawn, self._on_spawn)
        bus.serve(graph_names.KILL, interfaces.kill, self._on_kill)
        for name, kind in drawing.items():  # nothing is drawn, but solutions wait for an answer
            bus.serve(name, kind, lambda request: request.answer(Empty()))
        bus.serve(graph_names.RESET, EMPTY, self._on_reset)
        self._listeners = [bus.listeners_to(topic) for topic in self._watched]
        service.subscribe(self._publish_list)

    def begin(self, seed: int | None) -> None:
        """Begin a match; its clock stands until the first `tick`."""
        for seat in self.seats:
            seat.stop()
        self._service.reset(seed)
        self._agents.begin(self._service.seed)
        self._standing = (0,) * len(self._names), False

    @property
    def missing(self) -> list[RosSeat]:
        """The seats that no node drives yet, as far as the bus reports it."""
        return [seat for seat in self.seats if seat.state != "driven" and not self._publishers(seat)]

    def wait(self) -> None:
        """Let a tick pass while the clock stands, so that nodes get the state and find each other."""
        self._bus.spin()
        self._publish_state(self._service.world)

    def tick(self) -> None:
        """R1.4: play one step. R8.4: the requests since the step before are judged in it."""
        self._bus.spin()
        before = self._service.world
        commands = {
            seat.hunter: seat.command(before.time_ms, before.time_ms + TICK_MS, targets=bool(before.targets))
            for seat in self.seats
        }
        pending, self._pending = self._pending, []
        requests = [(seat.hunter, CatchTurtleRequest(request.message.name)) for seat, request in pending]
        requests += self._agents.act(before.time_ms)
        rulings = self._service.step(commands | self._agents.cmd_vel, requests, self._agents.active_targets)
        for (seat, request), ruling in zip(pending, rulings, strict=False):
            request.answer(CatchTurtleResponse(ruling.success))
            seat.note(ruling, {name for hunter, (name,) in requests if hunter == seat.hunter})
        world = self._service.world
        by_name = {hunter for hunter, _ in requests}
        hosted = [ruling for ruling in world.rulings if world.hunters[ruling.hunter].name not in by_name]
        for ruling in (*rulings, *hosted):
            self._rulings(RulingMessage.of(ruling, before.time_ms, self._service.config.hunter_names))
        self._publish_state(world)

    def standings(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """R6.1, R11.1: return ranks and scores by seat. A team shares its rank; one whose agents all failed is last."""
        scores = tuple(hunter.score for hunter in self._service.world.hunters)
        config = self._service.config
        teams = config.team_seats
        failed = self._agents.forfeits
        lasted = [max(failed[seat] for seat in team) if failed.keys() >= set(team) else None for team in teams]
        ranks = ranks_of([sum(scores[seat] for seat in team) for team in teams], lasted)
        return tuple(ranks[team] for team in config.team_by_seat), scores

    def log_missing(self, *, again: bool) -> None:
        """Log the seats that wait for a node, with a command for each; `again` adds the nodes that were seen."""
        shared = len(self.seats) > 1
        for seat in self.missing:
            topic = graph_names.cmd_vel_of(seat.hunter) if shared else _EXERCISE_CMD_VEL
            self._log(f"waiting for {seat.player} on {topic}: {run_line(seat.hunter, shared=shared)}")
        if again and self._bus.graph() is not None:
            seen = ", ".join(self._neighbours.seen) or "no other node: same ROS_DOMAIN_ID? same network?"
            self._log(f"seen: {seen}; `catch-arena ros doctor` shows more")

    def remarks(self) -> tuple[str, ...]:
        """Return lines for the authors of nodes, to print after the ranking."""
        return tuple(line for seat in self.seats for line in seat.remarks())

    # publishing

    def _optional_publisher(self, topic: str, kind: MessageType) -> Callable[[Any], None]:
        """Announce a topic with a type of our own package, which another ROS may not have."""
        try:
            return self._bus.publisher(topic, kind)
        except BusError:
            return lambda _: None

    def _publish_state(self, world: World) -> None:
        """Publish the poses and all changes; from time to time also the rest, for new listeners."""
        for hunter, publishers in zip(world.hunters, self._poses, strict=True):
            for publish in publishers:
                publish(hunter.pose)
        if self._clock is not None:
            seconds, rest = divmod(world.time_ms, 1000)
            self._clock(Clock(Time(seconds, rest * 1_000_000)))
        listeners = [self._bus.listeners_to(topic) for topic in self._watched]
        if listeners != self._listeners:
            self._listeners, self._list_from = listeners, self._ticks + _HELD
        often = self._ticks % _OFTEN == 0
        moved = often and self._service.config.targets_move
        if self._ticks % _SECOND == 0 or moved or self._ticks == self._list_from:
            self._publish_list(world.alive_turtles)
        if often:
            for seat in self.seats:
                seat.look_for(self._publishers(seat))
            if len(self.seats) > 1 and self._bus.publishers_of(_EXERCISE_CMD_VEL):
                self._explain_remapping()  # the node may wait for a pose before its first Twist
        if self._ticks % _SECOND == _SECOND // 2 and (graph := self._bus.graph()) is not None:
            self._serve(self._neighbours.look(graph, [seat.hunter for seat in self.missing]))
        self._publish_standings(world)
        self._ticks += 1

    def _publish_list(self, turtles: TurtleArray) -> None:
        """Publish the list, but no empty one before the first target: some solutions of the exercise end at that."""
        if self._ticks >= self._list_from and (turtles.turtles or self._service.world.spawned):
            for publish in self._lists:
                publish(turtles)

    def _publish_standings(self, world: World) -> None:
        """Publish all standings if there is news, else each once a second, in a tick of its own: no queue overflows."""
        ranks, scores = self.standings()
        is_news = (scores, self._service.over) != self._standing
        for seat, hunter in enumerate(world.hunters):
            if is_news or self._ticks % _SECOND == seat:
                time_s, player = world.time_ms / 1000.0, self._names[seat]
                self._standings(
                    StandingMessage(time_s, hunter.name, player, scores[seat], ranks[seat], self._service.over)
                )
        self._standing = scores, self._service.over

    # nodes

    def _serve(self, other_names: Mapping[str, str]) -> None:
        """Serve names that a node uses in the place of the usual ones."""
        for name, usual in other_names.items():
            self._log(
                f"a node uses {name}, so it is served like {usual} (or start it with --ros-args -r {name}:={usual})"
            )
            if usual == graph_names.CATCH_TURTLE:
                self._bus.serve(name, self._interfaces.catch_turtle, self._on_catch_turtle)
            else:
                self._lists.append(self._bus.publisher(name, self._interfaces.turtle_array))

    def _explain_remapping(self) -> None:
        """Log once how a node that drives turtle1 becomes one of the hunters that no node drives."""
        if self._remapping_explained:  # `missing` queries the bus, which is too slow for each Twist of a flood
            return
        self._remapping_explained = True
        free = (self.missing or self.seats)[0]
        self._log(
            f"warning: a node drives {graph_names.TURTLE}, but no hunter has that name if several seats are for "
            f"nodes: start it with {remapping_to(free.hunter)} to drive {free.hunter} ({free.player})"
        )

    def _publishers(self, seat: RosSeat) -> int | None:
        found = [self._bus.publishers_of(graph_names.cmd_vel_of(turtle)) for turtle in seat.turtles]
        reported = [number for number in found if number is not None]
        return sum(reported) if reported else None

    # services

    def _on_catch_turtle(self, request: Request) -> None:
        """Take a request at the shared service, or refuse it unless one seat is for nodes: no bus names the client."""
        if len(self.seats) == 1:
            self._ask(self.seats[0], request)
        else:
            if self.seats:
                self._log_once.warn(
                    "a node calls /catch_turtle, but several seats are for nodes: it must call the service of its "
                    "hunter, for example with --ros-args -r /catch_turtle:=/hunter_0/catch_turtle"
                )
            request.answer(_REFUSED)

    def _ask(self, seat: RosSeat, request: Request) -> None:
        """R8.4: keep a request for the next step, or refuse it immediately if it is one too many."""
        if seat.only_drives:
            self._log_once.warn(
                f"the arena requests the targets within reach of {seat.hunter} (R4.4): requests by nodes are refused"
            )
        elif sum(one is seat for one, _ in self._pending) < _MOST_JUDGED:
            self._pending.append((seat, request))
            return
        request.answer(_REFUSED)

    def _on_spawn(self, request: Request) -> None:
        """R8.1: spawn a target with the arena's next name; a place outside is moved to the wall, as in turtlesim."""
        spawn: SpawnRequest = request.message
        side = self._service.world.side_m
        name = ""
        try:
            x, y = (min(max(place, 0.0), side) for place in (spawn.x, spawn.y))
            name = self._service.spawn(x, y, spawn.theta)
        except (ActionError, EpisodeError) as error:
            self._log_once.warn(f"{graph_names.SPAWN}: {error}", "spawn")
        else:
            if not name:
                limit = self._service.config.max_targets
                self._log_once.warn(f"{graph_names.SPAWN}: the arena is full, with {limit} targets: nothing is spawned")
        request.answer(Name(name))

    def _on_kill(self, request: Request) -> None:
        """R8.1: judge /kill of a target as a request to catch it, so that no target is taken from afar."""
        name, kill = request.message.name, graph_names.KILL
        if self.seats and name in {target.name for target in self._service.world.targets}:
            if len(self.seats) == 1:
                self._log_once.warn(f"{kill} of a target is judged as a request to catch it")
                wanted = CatchTurtleRequest(name)
                self._ask(self.seats[0], Request(wanted, lambda _: request.answer(Empty())))
                return
            self._log_once.warn(f"{kill} of a target is refused: call {graph_names.CATCH_TURTLE} instead")
        else:
            try:
                self._service.kill(name)
            except EpisodeError as error:
                self._log_once.warn(f"{kill}: {error}")
        request.answer(Empty())

    def _on_reset(self, request: Request) -> None:
        if self._service.is_recorded:
            self._log_once.warn(f"{graph_names.RESET}: a recorded match cannot be reset, and continues")
        else:
            self.begin(None)
        request.answer(Empty())
