"""Our rosbridge bus speaks the protocol's JSON with a server of the tests' own."""

import json
import math
import threading
import time
from types import SimpleNamespace

import pytest
from ros.bridge import running_bridge
from websockets.sync.client import connect

from catch_arena.errors import BusError
from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse, Turtle, TurtleArray
from catch_arena.ros.middleware import rosbridge_bus
from catch_arena.ros.middleware.interfaces import EMPTY, TWIST, Empty, Interfaces, TwistMessage
from catch_arena.ros.middleware.opening import open_bus
from catch_arena.ros.middleware.rosbridge_bus import to_json

TYPES = Interfaces()


@pytest.fixture
def bridge():
    with running_bridge() as (server, url):
        yield server, url


@pytest.fixture
def joined(bridge):
    """Our bus, and its lines."""
    log_lines = []
    made = open_bus(bridge[1], log=log_lines.append)
    yield made, log_lines
    made.close()


def until(joined, ready, seconds=60.0):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        joined[0].spin(0.01)
        if ready():
            return
    raise AssertionError(f"it does not come; said: {joined[1]}")


def frames(bridge, does):
    """Return the number of frames that the server has read: it reads each client in a thread of its own."""
    return sum(frame["op"] == does for frame in list(bridge[0].frames))


def send(socket, **frame):
    socket.send(json.dumps(frame))


def published(topic, speed):
    return json.dumps({"op": "publish", "topic": topic, "msg": to_json(TWIST, TwistMessage.of(speed, 2.0))})


def test_a_student_hears_topics_drives_and_calls(bridge, joined):
    ours, _ = joined
    received, requests = [], []
    publish = ours.publisher("/alive_turtles", TYPES.turtle_array)
    ours.subscribe("/turtle1/cmd_vel", TWIST, received.append)
    ours.serve("/catch_turtle", TYPES.catch_turtle, requests.append)
    until(joined, lambda: len(bridge[0].frames) == 3)
    assert bridge[0].frames == [
        {"op": "advertise", "topic": "/alive_turtles", "type": "my_robot_interfaces/msg/TurtleArray"},
        {"op": "subscribe", "topic": "/turtle1/cmd_vel", "type": "geometry_msgs/msg/Twist"},
        {"op": "advertise_service", "service": "/catch_turtle", "type": "my_robot_interfaces/srv/CatchTurtle"},
    ]
    with connect(bridge[1]) as socket:
        send(socket, op="subscribe", topic="/alive_turtles")
        twist = {"linear": {"x": 1, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": -2.5}}
        send(socket, op="publish", topic="/turtle1/cmd_vel", msg=twist)
        send(socket, op="call_service", id="my call", service="/catch_turtle", args={"name": "tom"})
        until(joined, lambda: received and requests)

        assert received == [TwistMessage.of(1.0, -2.5)]
        assert requests[0].message == CatchTurtleRequest("tom")

        requests[0].answer(CatchTurtleResponse(True))
        answer = {"op": "service_response", "service": "/catch_turtle", "id": "my call"}
        assert json.loads(socket.recv(60)) == answer | {"values": {"success": True}, "result": True}

        publish(TurtleArray((Turtle("tom", 1.0, 2.0, 3.0),)))
        turtles = {"turtles": [{"name": "tom", "x": 1.0, "y": 2.0, "theta": 3.0}]}
        assert json.loads(socket.recv(60)) == {"op": "publish", "topic": "/alive_turtles", "msg": turtles}


def test_a_server_that_goes_away_is_told_once_and_harms_nothing(bridge, joined):
    """A match plays on to its end, and is recorded."""
    ours, log_lines = joined
    publish = ours.publisher("/x", TWIST)
    until(joined, lambda: bridge[0].frames)
    bridge[0].hang_up()
    until(joined, lambda: log_lines)
    ours.client("/kill", EMPTY).call(Empty())
    publish(TwistMessage.of(0.0, 0.0))
    ours.spin()
    said = [line for line in log_lines if "/kill" not in line]  # a call has a connection of its own
    assert said == ["warning: rosbridge: the connection is lost: start the server and this command again"]


@pytest.mark.parametrize("url", ["ws://127.0.0.1:1", "ws://", "ws://127.0.0.1:99999"])
def test_without_a_server_it_is_one_line_that_says_how_to_start_one(url):
    """No traceback of websockets'."""
    with pytest.raises(BusError, match=f"no rosbridge server answers at {url} .*: start one where ROS is") as error:
        open_bus(url)
    assert "\n" not in str(error.value)


def test_a_service_that_nobody_serves_is_told(bridge, joined):
    """Once, in the server's words, since `ready` cannot know. No connection stays."""
    ours, log_lines = joined
    client = ours.client("/kill", EMPTY)
    assert client.ready()
    calls = [client.call(Empty()) for _ in range(3)]
    until(joined, lambda: log_lines and len(bridge[0].clients) == 1)
    assert log_lines == ["warning: rosbridge: /kill: Service /kill does not exist"]
    assert [call.done() for call in calls] == [False] * 3


def test_what_is_no_message_is_left_out_and_told_once(bridge, joined):
    ours, log_lines = joined
    received, requests = [], []
    ours.subscribe("/t", TWIST, received.append)
    ours.serve("/catch_turtle", TYPES.catch_turtle, requests.append)
    until(joined, lambda: len(bridge[0].frames) == 2)
    odd = ({"x": x, "y": 0, "z": 0} for x in ("1", True, 10**400, [0.0]))
    for message in (None, 3, {}, {"linear": 1, "angular": {}}, *({"linear": one, "angular": one} for one in odd)):
        bridge[0].raw(json.dumps({"op": "publish", "topic": "/t", "msg": message}))
    for text in ("no json", "[]", '"x"', "{}", '{"op": "publish"}', '{"op": "dance", "topic": "/t"}'):
        bridge[0].raw(text)
    bridge[0].raw(json.dumps({"op": "status", "level": "error", "msg": "unknown \x1b[31m type"}))
    for number, arguments in enumerate(({"name": 3}, {"name": None}, {}, 7), start=1):
        call_frame = {"op": "call_service", "id": str(number), "service": "/catch_turtle", "args": arguments}
        bridge[0].raw(json.dumps(call_frame))
        until(joined, lambda number=number: frames(bridge, "service_response") == number)
        assert (bridge[0].frames[-1]["id"], bridge[0].frames[-1]["result"]) == (str(number), False)
    bridge[0].raw(published("/t", 1.0))
    until(joined, lambda: received)

    assert (received, requests) == ([TwistMessage.of(1.0, 2.0)], [])
    assert sorted(line.partition(": Expected ")[0] for line in log_lines) == [
        "warning: rosbridge: a message on /catch_turtle cannot be read: my_robot_interfaces/srv/CatchTurtle_Request",
        "warning: rosbridge: a message on /t cannot be read: geometry_msgs/msg/Twist",
        f"warning: rosbridge: the server at {bridge[1]} does not speak rosbridge's protocol",
        "warning: rosbridge: unknown \\x1b[31m type",
    ]


def test_a_number_that_is_not_finite_is_null_in_json_and_a_nan_here(bridge, joined):
    """So that the arena says what is wrong with such a Twist."""
    ours, log_lines = joined
    received = []
    ours.subscribe("/t", TWIST, received.append)
    until(joined, lambda: bridge[0].frames)
    zero = {"x": 0.0, "y": 0.0, "z": 0.0}
    bridge[0].raw(json.dumps({"op": "publish", "topic": "/t", "msg": {"linear": zero | {"x": None}, "angular": zero}}))
    until(joined, lambda: received)
    assert math.isnan(received[0].linear.x)
    assert (received[0].angular.z, log_lines) == (0.0, [])


def test_a_flood_leaves_the_newest(bridge, joined, monkeypatch):
    """A queue of ROS holds ten messages."""
    ours, _ = joined
    received = []
    ours.subscribe("/t", TWIST, lambda message: received.append(message.linear.x))
    until(joined, lambda: bridge[0].frames)
    for number in range(2000):
        bridge[0].raw(published("/t", float(number)))
    ours._connection.ping().wait(60)  # its answer comes after them
    monkeypatch.setattr(rosbridge_bus, "time", SimpleNamespace(monotonic=lambda: 0.0))
    ours.spin()
    assert received == list(range(1990, 2000))


def test_its_services_end_with_it(bridge, joined, monkeypatch):
    """However long the server takes to read it: it keeps services whose client has gone, and nobody would answer."""
    monkeypatch.setattr(rosbridge_bus, "_READ_S", 60.0)
    ours, _ = joined
    server, _ = bridge
    for service in ("/spawn", "/kill"):
        ours.serve(service, EMPTY, print)
    until(joined, lambda: len(server.services) == 2)
    closing = threading.Thread(target=ours.close)
    with server.reading:
        closing.start()
        closing.join(0.3)
    closing.join(60)
    assert server.services == {}


def test_a_call_holds_up_neither_topics_nor_services_nor_other_calls(bridge, joined):
    """The server reads nothing more of a connection until a call that came over it is answered."""
    ours, _ = joined
    publish = ours.publisher("/turtle1/cmd_vel", TWIST)
    ours.serve("/kill", EMPTY, lambda request: request.answer(Empty()))
    client = ours.client("/catch_turtle", TYPES.catch_turtle)
    with connect(bridge[1]) as socket, connect(bridge[1]) as other:
        send(socket, op="advertise_service", service="/catch_turtle", type=TYPES.catch_turtle.name)
        until(joined, lambda: len(bridge[0].services) == 2)
        calls = [client.call(CatchTurtleRequest(name)) for name in ("a", "b")]
        requests = sorted((json.loads(socket.recv(60)) for _ in calls), key=lambda frame: frame["args"]["name"])
        publish(TwistMessage.of(1.0, 2.0))
        until(joined, lambda: frames(bridge, "publish"))
        send(other, op="call_service", service="/kill", args={})  # as a node does that is asked to catch one
        until(joined, lambda: frames(bridge, "service_response"))
        send(socket, op="service_response", id=requests[1]["id"], service="/catch_turtle", values={"success": True})
        until(joined, calls[1].done)
    assert (calls[0].done(), calls[1].result(0)) == (False, CatchTurtleResponse(True))
