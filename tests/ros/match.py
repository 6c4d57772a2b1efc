"""A match on a bus of the test's own, tick by tick."""

from ros.local import Hub

from catch_arena.core.physics import TICK_MS
from catch_arena.messages import CatchTurtleRequest
from catch_arena.ros.arena_service import ArenaService
from catch_arena.ros.middleware.interfaces import TWIST, Interfaces, TwistMessage
from catch_arena.ros.nodes.agents import AgentSeats
from catch_arena.ros.nodes.arena_node import ArenaNode
from catch_arena.tournament.players import Players

TYPES = Interfaces()


class Match:
    """The arena's node, and one bus for each of the test's own nodes, `a`, `b` and `c`."""

    def __init__(self, hunters=1, players=None, names=None, clock=False, record=False, people=(), **settings):
        settings = {"initial_targets": 0, "spawn_frequency_hz": 0.001} | settings
        controls = dict(players.controls) if players else {}
        self.service = ArenaService(
            "standard",
            hunters=hunters,
            control_period_ms=TICK_MS,
            control=tuple(controls.get(seat, "velocity" if seat in people else "full") for seat in range(hunters)),
            **settings,
        )
        names = names or [f"p{seat}" for seat in range(hunters)]
        if record:
            self.service.record(names)
        self.hub, self.log_lines = Hub(), []
        self.a, self.b, self.c = (self.hub.bus(peer) for peer in "abc")
        self.agents = AgentSeats(self.service, players or Players({}), self.log_lines.append)
        driven = [seat for seat in range(hunters) if seat not in controls]
        self.node = ArenaNode(
            self.hub.bus("arena"),
            self.service,
            driven,
            names,
            self.agents,
            TYPES,
            clock=clock,
            log=self.log_lines.append,
        )
        self.node.begin(1)

    def drive(self, bus, speed=0.0, turn_rate=0.0, turtle="hunter_0"):
        bus.publisher(f"/{turtle}/cmd_vel", TWIST)(TwistMessage.of(speed, turn_rate))

    def request(self, bus, name, service="/catch_turtle"):
        return bus.client(service, TYPES.catch_turtle).call(CatchTurtleRequest(name))

    def tick(self, count=1):
        for _ in range(count):
            self.node.tick()
            for bus in (self.a, self.b, self.c):
                bus.spin()

    def sent(self, topic):
        return self.hub.sent.get(topic, [])

    def hunter(self, seat=0):
        return self.service.world.hunters[seat]
