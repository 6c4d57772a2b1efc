"""The arena as nodes of a ROS 2 bus: turtlesim's part, the exercise's spawner's, and the arbiter's."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Any, Final

from catch_arena.core.physics import TICK_MS
from catch_arena.errors import ActionError, BusError, EpisodeError
from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse, TurtleArray
from catch_arena.ros.middleware import graph_names
from catch_arena.ros.middleware.bus import Bus, Log, Request
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
    SpawnRequest,
    StandingMessage,
    Time,
)
from catch_arena.ros.middleware.rulings import ruling_message
from catch_arena.ros.nodes.agents import AgentSeats
from catch_arena.ros.nodes.neighbours import Neighbours, remapping_to, run_line
from catch_arena.ros.nodes.seats import RosSeat, seat_of
from catch_arena.service import ArenaService, response
from catch_arena.text import one_line
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.ranks import ranks_of
from catch_arena.verdicts import Ruling, Verdict
from catch_arena.world import World

_SECOND: Final = 1000 // TICK_MS
"""In ticks: what listeners may have missed is told again."""
_OFTEN: Final = 6
"""In ticks: targets that move are told anew, and who has gone is looked for."""
_MOST_JUDGED: Final = 4
"""R8.4: of one hunter's catch requests in one step, by its driver and by others. Only the first can be granted, and
whoever shares the service hears all answers, in a queue of ten.
"""
_HELD: Final = 10
"""In ticks: a new node has heard its pose before it hears the list of targets, as many solutions need."""
_AGAIN: Final = 10
"""After so many requests for targets that are gone, its author is told."""
_EXERCISE_CMD_VEL: Final = graph_names.cmd_vel_of(graph_names.TURTLE)
_NOT_JUDGED: Final = CatchTurtleResponse(success=False)
"""What is answered where no hunter asks, or too many do."""


@dataclass(frozen=True, slots=True)
class _PendingRequest:
    """A catch request that waits for the next step."""

    hunter: str
    request: Request
    foreign: bool
    """Whether another node asks than the one that drives the hunter, as far as the middleware tells."""


class ArenaNode:
    """Plays the arena, one tick after the other, with whoever is on the bus.

    Args:
        bus: the bus.
        service: the arena, before its reset; its control period is TICK_MS, turtlesim's own tick (R1.2): 62.5 a second.
        driven: the seats that nodes drive.
        names: the players', by seat.
        agents: those in the other seats, where there are any.
        interfaces: the packages of the types.
        clock: whether /clock tells the arena's time.
        log: takes one line when there is news.
    """

    def __init__(
        self,
        bus: Bus,
        service: ArenaService,
        driven: Collection[int],
        names: Sequence[str],
        agents: AgentSeats | None,
        interfaces: Interfaces,
        *,
        clock: bool,
        log: Log,
    ) -> None:
        self._bus, self._service, self._agents, self._log = bus, service, agents, log
        hunters = service.config.hunter_names
        self._names = names
        self._parties = Parties.of(service.config)
        self.seats = [
            RosSeat(hunters[seat], log, only_drives=service.config.controls[seat] == "velocity")
            for seat in sorted(driven)
        ]
        self._neighbours = Neighbours(hunters, [seat.hunter for seat in self.seats], interfaces, log)
        self._pending: list[_PendingRequest] = []
        self._too_far: dict[str, list[int]] = {seat.hunter: [] for seat in self.seats}
        """By hunter: how far away its targets were when it asked for them from out of reach [um]."""
        self._too_late = dict.fromkeys(self._too_far, 0)
        self._list_from = 0
        """The first tick in which the list of targets may go out."""
        self._logged: set[str] = set()
        self._other_names: set[str] = set()
        self._interfaces = interfaces
        self._ticks = 0
        self._standing: tuple[tuple[int, ...], bool] = (), False
        """The scores, and whether the match has ended, as they were told last."""
        self._topics = {seat.hunter: [graph_names.cmd_vel_of(seat.hunter)] for seat in self.seats}
        poses = {hunter: [graph_names.pose_of(hunter)] for hunter in hunters}
        if len(self.seats) == 1:  # the exercise's own names
            (only,) = self.seats
            self._topics[only.hunter].append(_EXERCISE_CMD_VEL)
            poses[only.hunter].append(graph_names.pose_of(graph_names.TURTLE))
        elif self.seats:  # nobody has them: a node that was not remapped is told so
            bus.subscribe(_EXERCISE_CMD_VEL, TWIST, lambda _twist, _peer: self._explain_remapping())
        self._pose_topics = [topic for seat in self.seats for topic in poses[seat.hunter]]
        self._poses = [[bus.publisher(topic, interfaces.pose) for topic in poses[hunter]] for hunter in hunters]
        self._lists = [bus.publisher(graph_names.ALIVE_TURTLES, interfaces.turtle_array)]
        self._rulings = self._optional_publisher(graph_names.RULINGS, RULING)
        self._standings = self._optional_publisher(graph_names.STANDINGS, STANDING)
        self._clock = bus.publisher(graph_names.CLOCK, CLOCK) if clock else None
        for seat in self.seats:
            for topic in self._topics[seat.hunter]:
                bus.subscribe(topic, TWIST, seat.on_twist)
            bus.serve(
                graph_names.catch_turtle_of(seat.hunter), interfaces.catch_turtle, self._catch_turtle_callback(seat)
            )
        bus.serve(graph_names.CATCH_TURTLE, interfaces.catch_turtle, self._on_catch_turtle)
        bus.serve(graph_names.SPAWN, interfaces.spawn, self._on_spawn)
        bus.serve(graph_names.KILL, interfaces.kill, self._on_kill)
        bus.serve(graph_names.CLEAR, EMPTY, lambda request: request.answer(Empty()))  # there is no drawing
        bus.serve(graph_names.RESET, EMPTY, self._on_reset)
        self._listeners = [bus.listeners_to(topic) for topic in self._pose_topics]
        service.subscribe(self._publish_list)

    def begin(self, seed: int | None) -> None:
        """A match begins; its clock stands until the first `tick`."""
        for seat in self.seats:
            seat.stop()
        self._service.reset(seed)
        if self._agents is not None:
            self._agents.begin(self._service.seed)
        self._standing = (0,) * len(self._names), False

    @property
    def over(self) -> bool:
        """Whether the match has ended."""
        return self._service.over

    @property
    def missing(self) -> list[RosSeat]:
        """The seats that no node drives yet, as far as the middleware tells."""
        return [seat for seat in self.seats if not seat.driven and not self._publishers(seat)]

    def wait(self) -> None:
        """One tick in which the clock stands: nodes hear where all is, and get to know each other."""
        self._bus.spin()
        self._publish_state(self._service.world)

    def tick(self) -> None:
        """R1.4: one step. R8.4: what came since the step before is judged in this one."""
        self._bus.spin()
        before = self._service.world
        targets = bool(before.targets)
        commands = {
            seat.hunter: seat.command(before.time_ms, before.time_ms + TICK_MS, targets=targets) for seat in self.seats
        }
        goals: dict[str, str] = {}
        asked, self._pending = sorted(self._pending, key=lambda one: one.foreign), []
        requests = [(one.hunter, CatchTurtleRequest(one.request.message.name)) for one in asked]
        if self._agents is not None and not self.over:
            theirs = self._agents.act(before.time_ms)
            commands |= theirs.cmd_vel
            goals = theirs.goals
            requests += theirs.requests
        rulings = self._service.step(commands, requests, goals)
        for one, ruling in zip(asked, rulings, strict=False):
            one.request.answer(response(ruling))
            self._note(one, ruling, asked)
        world = self._service.world
        asking = {hunter for hunter, _ in requests}
        hosted = [ruling for ruling in world.rulings if world.hunters[ruling.hunter].name not in asking]
        for ruling in (*rulings, *hosted):
            self._rulings(ruling_message(ruling, before.time_ms, self._service.config.hunter_names))
        self._publish_state(world)

    def standings(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """R6.1, R11.1: ranks and scores, by seat; team-mates share their team's rank. An agent that has failed comes
        last, and so does a team of which all have.
        """
        scores = tuple(hunter.score for hunter in self._service.world.hunters)
        failed = self._agents.forfeits if self._agents is not None else {}
        lasted: list[int | None] = []
        for seats in self._parties.seats:
            ends = [failed[seat] for seat in seats if seat in failed]
            lasted.append(max(ends) if len(ends) == len(seats) else None)
        ranks = ranks_of([sum(scores[seat] for seat in seats) for seats in self._parties.seats], lasted)
        return tuple(self._parties.to_seats(ranks)), scores

    def remarks(self) -> tuple[str, ...]:
        """What the authors of nodes should know after the match, a line for each."""
        lines = []
        for hunter, distances in self._too_far.items():
            if distances:
                reach = self._service.config.reaches[self._service.config.hunter_names.index(hunter)]
                near, far = min(distances) / 1e6, max(distances) / 1e6
                times = "1 request" if len(distances) == 1 else f"{len(distances)} requests"
                lines.append(
                    f"{self._player(hunter)}: {times} from too far, {near:.2f} to {far:.2f} m away: "
                    f"a catch needs less than reach_m, {reach:g} m"
                )
        return tuple(lines)

    def tell_who_is_missing(self, *, again: bool) -> None:
        """Say what is waited for, with the command for each seat; after a while also what was seen meanwhile."""
        shared = len(self.seats) > 1
        for seat in self.missing:
            topic = graph_names.cmd_vel_of(seat.hunter) if shared else _EXERCISE_CMD_VEL
            waiting = f"waiting for {self._player(seat.hunter)} on {topic}"
            self._log(f"{waiting}: {run_line(seat.hunter, shared=shared)}")
        if again and self._bus.graph() is not None:
            seen = ", ".join(self._neighbours.seen) or "no other node: same ROS_DOMAIN_ID? same network?"
            self._log(f"seen: {seen}; `catch-arena ros doctor` says more")

    def _player(self, hunter: str) -> str:
        return self._names[self._service.config.hunter_names.index(hunter)]

    def _note(self, one: _PendingRequest, ruling: Ruling, asked: Sequence[_PendingRequest]) -> None:
        """Tell a node's author what it asks for in vain.

        Args:
            one: the request.
            ruling: what was ruled.
            asked: all requests of the step.
        """
        if ruling.verdict is Verdict.OUT_OF_REACH and ruling.distance_um is not None:
            self._too_far[one.hunter].append(ruling.distance_um)
        elif ruling.verdict is Verdict.DUPLICATE and not one.foreign:
            if len({other.request.message.name for other in asked if other.hunter == one.hunter}) > 1:
                hint = "only the first request of a step can be granted (R5.2): ask for one that is in reach"
                self._log_once(f"{one.hunter} asked for several targets at once; {hint}", f"{one.hunter} several")
        elif ruling.verdict in {Verdict.ALREADY_CAUGHT, Verdict.UNKNOWN_TARGET}:
            self._too_late[one.hunter] += 1
            if self._too_late[one.hunter] == _AGAIN:
                asked_for = one_line(one.request.message.name[:40])
                self._log(
                    f"{self._player(one.hunter)} has asked {_AGAIN} times for targets that are gone, as {asked_for}: "
                    f"choose another when yours leaves {graph_names.ALIVE_TURTLES}"
                )

    # publishing

    def _publish_list(self, turtles: TurtleArray) -> None:
        """An empty list is none before the first target, as with the exercise's spawner: some solutions end at it."""
        if self._ticks >= self._list_from and (turtles.turtles or self._service.world.spawned):
            for publish in self._lists:
                publish(turtles)

    def _optional_publisher(self, topic: str, kind: MessageType) -> Callable[[Any], None]:
        """A topic with a type of ours, which a ROS on the other side may not have."""
        try:
            return self._bus.publisher(topic, kind)
        except BusError:
            return lambda _: None

    def _publish_state(self, world: World) -> None:
        """Poses, and what has changed; and now and then what has not, for those that came late."""
        for hunter, publishers in zip(world.hunters, self._poses, strict=True):
            for publish in publishers:
                publish(hunter.pose)
        if self._clock is not None:
            seconds, rest = divmod(world.time_ms, 1000)
            self._clock(Clock(Time(seconds, rest * 1_000_000)))
        now = self._ticks % _SECOND
        often = self._ticks % _OFTEN == 0
        listeners = [self._bus.listeners_to(topic) for topic in self._pose_topics]
        if listeners != self._listeners:
            self._listeners, self._list_from = listeners, self._ticks + _HELD
        moved = often and self._service.config.targets_move
        if now == 0 or moved or self._ticks == self._list_from:
            self._publish_list(world.alive_turtles)
        if now == _SECOND // 2 and (graph := self._bus.graph()) is not None:
            self._neighbours.look(graph, [seat.hunter for seat in self.missing])
            self._serve_other_names()
        if often:
            for seat in self.seats:
                seat.look_for(self._publishers(seat))
            if len(self.seats) > 1 and self._bus.publishers_of(_EXERCISE_CMD_VEL):
                self._explain_remapping()  # it may wait for a pose before its first Twist
        ranks, scores = self.standings()
        is_news = (scores, self.over) != self._standing
        for number, hunter in enumerate(world.hunters):
            if is_news or now == number:  # each in a tick of its own: nobody's queue overflows
                self._standings(
                    StandingMessage(
                        world.time_ms / 1000.0,
                        hunter.name,
                        self._names[number],
                        scores[number],
                        ranks[number],
                        self.over,
                    )
                )
        self._standing = scores, self.over
        self._ticks += 1

    def _serve_other_names(self) -> None:
        for name, usual in self._neighbours.other_names.items():
            if name in self._other_names:
                continue
            self._other_names.add(name)
            self._log(f"a node uses {name}: it is served as {usual} (or start it with --ros-args -r {name}:={usual})")
            if usual == graph_names.CATCH_TURTLE:
                self._bus.serve(name, self._interfaces.catch_turtle, self._on_catch_turtle)
            else:
                self._lists.append(self._bus.publisher(name, self._interfaces.turtle_array))

    def _explain_remapping(self) -> None:
        if graph_names.TURTLE in self._logged:
            return
        free = [seat.hunter for seat in self.missing or self.seats]
        hunter, players = free[0], dict(zip(self._service.config.hunter_names, self._names, strict=True))
        others = [f"{one} ({players[one]})" for one in free[1:]]
        also = f"; in the same way for {', '.join(others)}" if others else ""
        self._warn_once(
            f"a node drives {graph_names.TURTLE}, which is no hunter where several seats are for nodes: start it with "
            f"{remapping_to(hunter)} to drive {hunter} ({players[hunter]}){also}",
            graph_names.TURTLE,
        )

    def _publishers(self, seat: RosSeat) -> frozenset[str] | None:
        found = [self._bus.publishers_of(topic) for topic in self._topics[seat.hunter]]
        known = [peers for peers in found if peers is not None]
        return frozenset().union(*known) if known else None

    # services

    def _catch_turtle_callback(self, seat: RosSeat) -> Any:
        def callback(request: Request) -> None:
            asks_for = [] if request.peer is None else [one for one in self.seats if one.driver == request.peer]
            if asks_for and seat not in asks_for:
                self._warn_once(f"the node that drives {asks_for[0].hunter} asks for {seat.hunter}: it is not heard")
                request.answer(_NOT_JUDGED)
            else:
                self._ask(seat, request)

        return callback

    def _on_catch_turtle(self, request: Request) -> None:
        """The service that all share."""
        seat = seat_of(request.peer, self.seats, self._warn_once)
        if seat is None:
            request.answer(_NOT_JUDGED)
        else:
            self._ask(seat, request)

    def _ask(self, seat: RosSeat, request: Request) -> None:
        """R8.4: in the next step."""
        if seat.only_drives:
            self._warn_once(f"{seat.hunter} asks by itself for what is in its reach (R4.4): no request for it is heard")
            request.answer(_NOT_JUDGED)
            return
        foreign = None not in (request.peer, seat.driver) and request.peer != seat.driver
        before = sum((one.hunter, one.foreign) == (seat.hunter, foreign) for one in self._pending)
        if before < _MOST_JUDGED:
            self._pending.append(_PendingRequest(seat.hunter, request, foreign))
        else:
            request.answer(_NOT_JUDGED)

    def _on_spawn(self, request: Request) -> None:
        """R8.1: a target of the arena's own next name; out of bounds turtlesim puts it at the wall, and so do we."""
        asked: SpawnRequest = request.message
        side = self._service.world.side_m
        try:
            x, y = (min(max(place, 0.0), side) for place in (asked.x, asked.y))
            name = self._service.spawn(x, y, asked.theta)
            if not name:
                most = self._service.config.max_targets
                self._warn_once(f"{graph_names.SPAWN}: the arena is full, with {most} targets: nothing is spawned")
            elif asked.name not in {"", name}:
                names = f"{name} for {one_line(asked.name[:40])}"
                self._warn_once(f"{graph_names.SPAWN}: the arena gives its targets names of its own: {names}", "names")
        except (ActionError, EpisodeError) as error:
            recorded = "nothing is spawned in a recorded match" if self._service.is_recorded else str(error)
            self._warn_once(f"{graph_names.SPAWN}: {recorded}", "spawn")
            name = ""
        request.answer(Name(name))

    def _on_kill(self, request: Request) -> None:
        """R8.1: a target that a player kills is one that it asks for: nobody is robbed of it from afar."""
        if request.message.name in {target.name for target in self._service.world.targets} and self.seats:
            if len(self.seats) == 1:
                self._warn_once(f"{graph_names.KILL} of a target is judged as a request to catch it")
                wanted = CatchTurtleRequest(request.message.name)
                self._ask(self.seats[0], Request(wanted, request.peer, lambda _: request.answer(Empty())))
                return
            self._warn_once(f"{graph_names.KILL} of a target is refused: ask {graph_names.CATCH_TURTLE} for it")
            request.answer(Empty())
            return
        try:
            self._service.kill(request.message.name)
        except EpisodeError as error:
            recorded = "nothing is killed in a recorded match" if self._service.is_recorded else str(error)
            self._warn_once(f"{graph_names.KILL}: {recorded}")
        request.answer(Empty())

    def _on_reset(self, request: Request) -> None:
        if self._service.is_recorded:
            self._warn_once(f"{graph_names.RESET}: a recorded match goes on to its end")
        else:
            self.begin(None)
        request.answer(Empty())

    def _warn_once(self, line: str, about: str = "") -> None:
        self._log_once(f"warning: {line}", about)

    def _log_once(self, line: str, about: str = "") -> None:
        """What has been told is known by its line, or by what it is about where the lines differ."""
        if (about or line) not in self._logged:
            self._logged.add(about or line)
            self._log(line)
