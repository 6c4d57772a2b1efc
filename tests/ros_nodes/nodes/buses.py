"""Two of our buses over rclpy in one process: a server that answers late, and its client. Prints `right` at the end."""

import sys
import time

from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse
from catch_arena.ros.middleware.interfaces import TWIST, Interfaces, TwistMessage
from catch_arena.ros.middleware.opening import open_bus

TYPES = Interfaces()
YES, NO = CatchTurtleResponse(success=True), CatchTurtleResponse(success=False)
ours, theirs = (open_bus("rclpy", node=name) for name in ("ours", "theirs"))
requests, received = [], []
ours.serve("/catch_turtle", TYPES.catch_turtle, requests.append)
publish = ours.publisher("/out", TWIST)
theirs.subscribe("/out", TWIST, received.append)
client = theirs.client("/catch_turtle", TYPES.catch_turtle)


def until(ready, *buses):
    end = time.monotonic() + 120
    while not ready():
        assert time.monotonic() < end
        for bus in buses:
            bus.spin(0.01)


until(lambda: client.ready() and theirs.publishers_of("/out") and ours.listeners_to("/out"), ours, theirs)
calls = [client.call(CatchTurtleRequest(name)) for name in "abc"]
until(lambda: len(requests) == 3, ours, theirs)
assert [call.done() for call in calls] == [False] * 3
by_name = dict(zip("abc", calls, strict=True))
requests[1].answer(YES)  # later ones are heard while earlier ones wait
publish(TwistMessage.of(1.0, 2.0))  # the answer leaves before it, without another spin of ours
until(lambda: received and by_name[requests[1].message.name].done(), theirs)
assert by_name[requests[1].message.name].result() == YES
assert received == [TwistMessage.of(1.0, 2.0)]
for one in (requests[0], requests[2]):
    one.answer(NO)
until(lambda: all(call.done() for call in calls), ours, theirs)
assert sorted(call.result().success for call in calls) == [False, False, True]
sys.stdout.write("right\n")
for bus in (ours, theirs):
    bus.close()
