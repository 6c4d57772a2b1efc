"""A process on our bus: what it hears on /in goes out on /out, in words; it serves /twice, and calls /other.

Arguments: domain.
"""

import sys
import time

from catch_arena.messages import CatchTurtleResponse, Turtle, TurtleArray
from catch_arena.ros.middleware.interfaces import TWIST, Interfaces, Name
from catch_arena.ros.middleware.opening import open_bus

TYPES = Interfaces()


def main(domain):
    bus = open_bus("cyclonedds", domain=domain, log=lambda line: sys.stderr.write(f"{line}\n"))
    out = bus.publisher("/out", TYPES.turtle_array)

    def tell(message):
        out(TurtleArray((Turtle(repr(message)[:1000], 0.0, 0.0, 0.0),)))

    bus.subscribe("/twist", TWIST, tell)
    bus.subscribe("/turtles", TYPES.turtle_array, tell)
    bus.serve(
        "/catch_turtle", TYPES.catch_turtle, lambda one: one.answer(CatchTurtleResponse(len(one.message.name) % 2 == 1))
    )
    bus.serve("/spawn", TYPES.spawn, lambda one: one.answer(Name(f"{one.message.name}:{one.message.x:g}")))
    client, call = bus.client("/kill", TYPES.kill), None
    end = time.monotonic() + 60
    while time.monotonic() < end:
        bus.spin(0.05)
        if call is None and client.ready:
            call = client.call(Name("end"))
        if call is not None and call.response is not None:
            break
    bus.close()


if __name__ == "__main__":
    main(int(sys.argv[1]))
