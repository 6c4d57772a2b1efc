"""rosbridge's JSON, with a server of the tests' own."""

import json
import logging
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
from catch_arena.ros.middleware.bus import SPIN_S, open_bus
from catch_arena.ros.middleware.interfaces import EMPTY, TWIST, Empty, Interfaces, TwistMessage
from catch_arena.ros.middleware.rosbridge_bus import from_json, to_json

TYPES = Interfaces()


@pytest.fixture
def bridge():
    with running_bridge() as (server, url):
        yield server, url


@pytest.fixture
def joined(bridge):
    """One of ours, and what it says."""
    said = []
    made = open_bus("rosbridge", url=bridge[1], log=said.append)
    yield made, said
    made.close()


def test_websockets_writes_no_line_for_each_frame_to_the_root_logger(caplog, bridge):
    """A program may have set that to DEBUG."""
    caplog.set_level(logging.DEBUG)
    made = open_bus("rosbridge", url=bridge[1], log=print)
    made.close()

    assert [record for record in caplog.records if record.name == "websockets.client"] == []


def until(joined, ready, seconds=60.0):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        joined[0].spin(0.01)
        if ready():
            return
    raise AssertionError(f"it does not come; said: {joined[1]}")


def subscriptions(bridge):
    """How many the server has heard of: it hears each client in a thread of its own."""
    return sum(frame["op"] == "subscribe" for frame in bridge[0].frames)


def student(url):
    """Another client of the server, which speaks JSON."""
    return connect(url)


def send(socket, **frame):
    socket.send(json.dumps(frame))


def test_it_begins_as_the_protocol_has_it(bridge, joined):
    """Each topic and each service with its type."""
    ours, _ = joined
    ours.publisher("/alive_turtles", TYPES.turtle_array)
    ours.subscribe("/turtle1/cmd_vel", TWIST, print)
    ours.serve("/catch_turtle", TYPES.catch_turtle, print)
    until(joined, lambda: len(bridge[0].frames) == 3)

    assert bridge[0].frames == [
        {"op": "advertise", "topic": "/alive_turtles", "type": "my_robot_interfaces/msg/TurtleArray"},
        {"op": "subscribe", "topic": "/turtle1/cmd_vel", "type": "geometry_msgs/msg/Twist"},
        {"op": "advertise_service", "service": "/catch_turtle", "type": "my_robot_interfaces/srv/CatchTurtle"},
    ]


def test_a_student_hears_topics_drives_and_calls(bridge, joined):
    """And gets the answer to its own call."""
    ours, _ = joined
    heard, asked = [], []
    publish = ours.publisher("/alive_turtles", TYPES.turtle_array)
    ours.subscribe("/turtle1/cmd_vel", TWIST, lambda message, peer: heard.append((message, peer)))
    ours.serve("/catch_turtle", TYPES.catch_turtle, asked.append)
    until(joined, lambda: len(bridge[0].frames) == 3)
    with student(bridge[1]) as socket:
        send(socket, op="subscribe", topic="/alive_turtles")
        send(socket, op="advertise", topic="/turtle1/cmd_vel", type="geometry_msgs/msg/Twist")
        twist = {"linear": {"x": 1, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": -2.5}}
        send(socket, op="publish", topic="/turtle1/cmd_vel", msg=twist)
        send(socket, op="call_service", id="my call", service="/catch_turtle", args={"name": "tom"})
        until(joined, lambda: heard and asked)

        assert heard == [(TwistMessage.of(1.0, -2.5), None)]
        assert asked[0].message == CatchTurtleRequest("tom")

        asked[0].answer(CatchTurtleResponse(True))
        answer = {"op": "service_response", "service": "/catch_turtle", "id": "my call"}
        assert json.loads(socket.recv(60)) == answer | {"values": {"success": True}, "result": True}

        publish(TurtleArray((Turtle("tom", 1.0, 2.0, 3.0),)))
        turtles = {"turtles": [{"name": "tom", "x": 1.0, "y": 2.0, "theta": 3.0}]}
        assert json.loads(socket.recv(60)) == {"op": "publish", "topic": "/alive_turtles", "msg": turtles}


def test_a_topic_is_heard_no_more_when_it_was_unsubscribed(bridge, joined):
    """Also by the server that comes back."""
    ours, said = joined
    heard = []
    for topic in ("/a", "/b"):
        ours.subscribe(topic, TWIST, lambda *_, topic=topic: heard.append(topic))
    ours.unsubscribe("/a")
    until(joined, lambda: len(bridge[0].frames) == 3)
    assert bridge[0].frames[-1] == {"op": "unsubscribe", "topic": "/a"}
    bridge[0].hang_up()
    until(joined, lambda: "rosbridge: the server is back" in said and subscriptions(bridge) == 3)
    with student(bridge[1]) as socket:
        for topic in ("/a", "/b"):
            send(socket, op="advertise", topic=topic, type=TWIST.name)
            send(socket, op="publish", topic=topic, msg=to_json(TWIST, TwistMessage.of(1.0, 2.0)))
        until(joined, lambda: heard)
    assert heard == ["/b"]


def test_it_calls_a_students_service(bridge, joined):
    """A call that fails stays without a response."""
    ours, _ = joined
    client = ours.client("/kill", EMPTY)
    assert client.ready
    nobody = client.call(Empty())
    until(joined, lambda: bridge[0].frames)
    with student(bridge[1]) as socket:
        send(socket, op="advertise_service", service="/kill", type=EMPTY.name)
        until(joined, lambda: len(bridge[0].frames) == 2)
        call = client.call(Empty())
        asked = json.loads(socket.recv(60))
        assert (asked["op"], asked["service"], asked["args"]) == ("call_service", "/kill", {})
        send(socket, op="service_response", id=asked["id"], service="/kill", values={}, result=True)
        until(joined, lambda: call.response is not None)
    assert (call.response, nobody.response) == (Empty(), None)


def test_it_goes_on_when_the_server_is_back(bridge, joined):
    """With all that was announced, and a line for each."""
    ours, said = joined
    heard = []
    ours.subscribe("/turtle1/cmd_vel", TWIST, lambda message, _: heard.append(message))
    until(joined, lambda: len(bridge[0].frames) == 1)
    bridge[0].hang_up()
    ours.publisher("/x", TWIST)(TwistMessage.of(0.0, 0.0))  # nobody is there
    until(joined, lambda: "rosbridge: the server is back" in said and subscriptions(bridge) == 2)
    assert said[0] == "warning: rosbridge: the connection is lost; it is tried again every second"
    with student(bridge[1]) as socket:
        send(socket, op="advertise", topic="/turtle1/cmd_vel", type=TWIST.name)
        send(socket, op="publish", topic="/turtle1/cmd_vel", msg=to_json(TWIST, TwistMessage.of(1.0, 2.0)))
        until(joined, lambda: heard)
    assert heard == [TwistMessage.of(1.0, 2.0)]


def test_without_a_server_it_is_one_line_that_says_how_to_start_one():
    """No traceback of websockets'."""
    with pytest.raises(BusError, match="ros2 launch rosbridge_server") as error:
        open_bus("rosbridge", url="ws://127.0.0.1:1")
    assert "\n" not in str(error.value)
    with pytest.raises(BusError, match="no rosbridge server answers at nonsense"):
        open_bus("rosbridge", url="nonsense")


def test_whatever_else_fails_when_it_connects_is_one_line_too(monkeypatch):
    """And nobody waits for ever."""

    def fail(*_, **__):
        raise ImportError("another package is needed")

    monkeypatch.setattr(rosbridge_bus, "connect", fail)
    with pytest.raises(BusError, match=r"no rosbridge server answers at ws://x \(another package is needed\)"):
        open_bus("rosbridge", url="ws://x")


def test_the_proxies_of_the_environment_are_not_asked(bridge, monkeypatch):
    """Which would not know this machine's own addresses."""
    for name in ("http_proxy", "https_proxy", "all_proxy", "socks_proxy", "ws_proxy"):
        monkeypatch.setenv(name, "http://127.0.0.1:1")
    for name in ("no_proxy", "NO_PROXY"):
        monkeypatch.delenv(name, raising=False)
    open_bus("rosbridge", url=bridge[1]).close()


def test_what_is_announced_while_the_server_comes_back_is_announced(bridge, joined):
    """At the last moment, when all that was announced before has been said again."""
    ours, _ = joined
    late = threading.Thread(target=ours.publisher, args=("/late", TWIST))

    class Announced(list):
        def __iter__(self):
            yield from [*super().__iter__()]
            late.start()
            late.join(0.3)

    ours.publisher("/early", TWIST)
    until(joined, lambda: bridge[0].frames)
    ours._announced = Announced(ours._announced)
    bridge[0].hang_up()
    until(joined, lambda: any(frame.get("topic") == "/late" for frame in bridge[0].frames))
    late.join(60)


def test_a_service_that_nobody_serves_is_told(joined):
    """Once, in the server's words: `ready` cannot know."""
    ours, said = joined
    client = ours.client("/kill", EMPTY)
    for _ in range(3):
        client.call(Empty())
    until(joined, lambda: said)
    ours.spin(0.1)
    assert said == ["warning: rosbridge: /kill: Service /kill does not exist"]


def test_what_is_no_message_is_left_out_and_told_once(bridge, joined):
    """What follows is heard; a request that is none is answered as failed."""
    ours, said = joined
    heard, asked = [], []
    ours.subscribe("/t", TWIST, lambda message, _: heard.append(message))
    ours.serve("/catch_turtle", TYPES.catch_turtle, asked.append)
    until(joined, lambda: len(bridge[0].frames) == 2)

    def answered():
        return sum(frame["op"] == "service_response" for frame in bridge[0].frames)

    bad = [None, 3, {}, {"linear": 1, "angular": {}}, {"linear": {"x": "1", "y": 0, "z": 0}, "angular": {}}]
    for message in bad:
        bridge[0].raw(json.dumps({"op": "publish", "topic": "/t", "msg": message}))
    for text in ("no json", "[]", '"x"', "{}", '{"op": "publish"}', '{"op": "dance", "topic": "/t"}', "[" * 100_000):
        bridge[0].raw(text)
    bridge[0].raw(json.dumps({"op": "status", "level": "error", "msg": "unknown \x1b[31m type"}))
    for count, arguments in enumerate(({"name": 3}, {"name": None}, {}, 7), start=1):
        bridge[0].raw(
            json.dumps({"op": "call_service", "id": str(count), "service": "/catch_turtle", "args": arguments})
        )
        until(joined, lambda count=count: answered() == count)
        assert (bridge[0].frames[-1]["id"], bridge[0].frames[-1]["result"]) == (str(count), False)
    good = to_json(TWIST, TwistMessage.of(1.0, 2.0))
    bridge[0].raw(json.dumps({"op": "publish", "topic": "/t", "msg": good}))
    until(joined, lambda: heard)

    assert (heard, asked) == ([TwistMessage.of(1.0, 2.0)], [])
    assert sum("/t cannot be read" in line for line in said) == 1
    assert sum("/catch_turtle cannot be read" in line for line in said) == 1
    assert "warning: rosbridge sent what is no JSON" in said
    assert all(line.isprintable() for line in said)


def test_a_flood_leaves_the_newest(bridge, joined):
    """As many as a queue of ROS's holds, so that reading them takes no time to speak of."""
    ours, _ = joined
    heard = []
    ours.subscribe("/t", TWIST, lambda message, _: heard.append(message.linear.x))
    until(joined, lambda: bridge[0].frames)
    for number in range(2000):
        bridge[0].raw(json.dumps({"op": "publish", "topic": "/t", "msg": to_json(TWIST, TwistMessage.of(number, 0.0))}))
    inbox = ours._inboxes["publish", "/t"]
    end = time.monotonic() + 60
    while time.monotonic() < end and not (inbox and inbox[-1]["msg"]["linear"]["x"] == 1999):
        time.sleep(0.01)
    ours.spin()
    assert heard == list(range(1990, 2000))


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
    with student(bridge[1]) as socket, student(bridge[1]) as other:
        send(socket, op="advertise_service", service="/catch_turtle", type=TYPES.catch_turtle.name)
        until(joined, lambda: len(bridge[0].services) == 2)
        calls = [client.call(CatchTurtleRequest(name)) for name in ("a", "b")]
        asked = sorted((json.loads(socket.recv(60)) for _ in calls), key=lambda frame: frame["args"]["name"])
        publish(TwistMessage.of(1.0, 2.0))
        until(joined, lambda: any(frame["op"] == "publish" for frame in bridge[0].frames))
        send(other, op="call_service", service="/kill", args={})  # as a node does that is asked to catch one
        until(joined, lambda: any(frame["op"] == "service_response" for frame in bridge[0].frames))
        send(socket, op="service_response", id=asked[1]["id"], service="/catch_turtle", values={"success": True})
        until(joined, lambda: calls[1].response is not None)
    assert (calls[0].response, calls[1].response) == (None, CatchTurtleResponse(True))


def test_calls_one_after_the_other_share_a_connection_until_the_server_comes_back(bridge, joined):
    """The server tells of each that comes and goes."""
    ours, said = joined
    failed = []
    client = ours.client("/kill", EMPTY, failed.append)

    def call(times):
        for _ in range(times):
            before = len(failed)
            until(joined, lambda: all(line.is_free for line in ours._lines))  # a moment after the answer
            client.call(Empty())
            until(joined, lambda before=before: len(failed) > before)

    call(3)
    assert len(bridge[0]._clients) == 2
    bridge[0].hang_up()
    until(joined, lambda: "rosbridge: the server is back" in said)
    call(1)
    assert failed == 4 * ["/kill: Service /kill does not exist"]


def test_a_frame_that_is_too_long_is_left_out_with_a_line_and_does_not_end_the_connection(bridge, joined):
    """A piece of what rosbridge has cut has 10 MB, and twice as many where all of it is quotes."""
    ours, said = joined
    heard = []
    ours.subscribe("/t", TWIST, lambda message, _: heard.append(message))
    until(joined, lambda: bridge[0].frames)
    bridge[0].raw(json.dumps({"op": "fragment", "id": "1", "num": 0, "total": 3, "data": '"' * 10_000_000}))
    bridge[0].raw(json.dumps({"op": "publish", "topic": "/t", "msg": to_json(TWIST, TwistMessage.of(1.0, 2.0))}))
    until(joined, lambda: heard)
    assert said == ["warning: rosbridge: a frame of more than 128 KiB is left out"]


def test_a_name_that_is_too_long_for_the_rules_is_read(bridge, joined):
    """R5.2 tells it from a short one."""
    ours, said = joined
    asked = []
    ours.serve("/catch_turtle", TYPES.catch_turtle, asked.append)
    until(joined, lambda: bridge[0].frames)
    bridge[0].raw(json.dumps({"op": "call_service", "service": "/catch_turtle", "args": {"name": "x" * 100_000}}))
    until(joined, lambda: asked)
    assert len(asked[0].message.name) == 100_000
    assert said == []


def test_a_spin_ends_in_time_and_has_heard_every_topic(joined, monkeypatch):
    """One topic's flood keeps no other waiting; its rest is heard in the next spins."""
    ours, _ = joined
    heard = []
    clock = [0.0]
    monkeypatch.setattr(rosbridge_bus, "time", SimpleNamespace(monotonic=lambda: clock[-1]))

    def slow(message, _):
        heard.append(message.linear.x)
        clock.append(clock[-1] + SPIN_S / 3)

    for topic in ("/flood", "/quiet"):
        ours.subscribe(topic, TWIST, slow)
    until_read = [("/flood", 1.0)] * 10 + [("/quiet", 2.0)]
    for topic, speed in until_read:
        frame = {"op": "publish", "topic": topic, "msg": to_json(TWIST, TwistMessage.of(speed, 0.0))}
        ours._sort_in(json.dumps(frame))
    ours.spin()
    assert heard[:2] == [1.0, 2.0]
    assert len(heard) < 10
    for _ in range(10):
        ours.spin()
    assert heard == [1.0, 2.0] + 9 * [1.0]


@pytest.mark.parametrize(
    ("kind", "values", "expected"),
    [
        (TYPES.catch_turtle.request, ["tom"], CatchTurtleRequest("tom")),  # by place, which the protocol allows
        (EMPTY.request, None, Empty()),
        (EMPTY.request, [], Empty()),
        (TYPES.turtle_array, {"turtles": []}, TurtleArray(())),
        (TYPES.turtle_array, {"turtles": [], "more": 1}, TurtleArray(())),
    ],
)
def test_messages_are_read_as_the_protocol_writes_them(kind, values, expected):
    """Fields that we do not know are nobody's mistake."""
    assert from_json(kind, values) == expected


def test_null_is_what_rosbridge_makes_of_numbers_that_json_does_not_have():
    """So it is no finite number here."""
    assert math.isnan(from_json(TYPES.pose, dict.fromkeys(TYPES.pose.make._fields)).x)


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        (TYPES.turtle_array, {"turtles": 3}),
        (TYPES.turtle_array, {"turtles": [3]}),
        (TYPES.pose, dict.fromkeys(TYPES.pose.make._fields, 10**400)),
        (TYPES.pose, dict.fromkeys(TYPES.pose.make._fields, True)),
        (TYPES.catch_turtle.response, {"success": 1}),
        (TYPES.catch_turtle.request, []),
    ],
)
def test_what_is_no_message_is_refused_in_one_line(kind, values):
    """Whatever is in it."""
    with pytest.raises(ValueError) as error:
        from_json(kind, values)
    assert len(str(error.value)) < 200
