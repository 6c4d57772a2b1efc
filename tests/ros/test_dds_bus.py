"""Our DDS bus and a node without our code exchange topics and services on the loopback interface."""

import gc
import sys
import time
import weakref

import pytest
from ros import wire
from ros.processes import own_domain

from catch_arena.errors import BusError
from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse, Turtle, TurtleArray
from catch_arena.ros.middleware import dds_bus, dds_domain, opening
from catch_arena.ros.middleware.bus import SERVICE_DEPTH
from catch_arena.ros.middleware.dds_domain import configuration, is_fast_dds, is_localhost_only
from catch_arena.ros.middleware.interfaces import TWIST, Interfaces, Name, TwistMessage
from catch_arena.ros.middleware.opening import describe_bus, open_bus

TYPES = Interfaces()


def until(ready, seconds=60.0):
    """Return the result of `ready` once it is true."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = ready()
        if found:
            return found
        time.sleep(0.005)
    raise AssertionError("it does not come")


@pytest.fixture(scope="module")
def domain():
    """A domain for this file, on this machine only."""
    with own_domain() as own, pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_LOCALHOST_ONLY", "1")
        patch.setenv("ROS_DOMAIN_ID", str(own))
        yield own


@pytest.fixture
def ours(domain):
    """Our bus in this process, and its lines."""
    del domain  # it is in ROS_DOMAIN_ID
    log_lines = []
    made = open_bus("cyclonedds", log=log_lines.append)
    yield made, log_lines
    made.close()


def test_topics_arrive_both_ways(ours, domain):
    made, _ = ours
    node, received = wire.Node(domain), []
    made.subscribe("/in", TYPES.turtle_array, received.append)
    out = made.publisher("/out", TWIST)
    turtles, twists = node.writer("rt/in", wire.TURTLES), node.reader("rt/out", wire.TWIST)
    until(lambda: turtles.matched() and twists.matched())
    for listed in ([("käse", 1.0, 2.0, 3.0)], []):
        turtles.write(wire.listed(*listed))
        until(lambda: made.spin() or received)
        assert received.pop() == TurtleArray(tuple(Turtle(*one) for one in listed))
    out(TwistMessage.of(1.5, -2.0))
    (twist,) = until(twists.take)
    assert (twist.linear.x, twist.angular.z) == (1.5, -2.0)


def test_services_are_answered_and_called_with_the_clients_id_and_a_number(ours, domain):
    """Both begin requests and responses. A long name is answered (R5.2); another client's response is not ours."""
    made, _ = ours
    node = wire.Node(domain)
    made.serve(
        "/catch_turtle", TYPES.catch_turtle, lambda one: one.answer(CatchTurtleResponse(len(one.message.name) > 9))
    )
    kill = made.client("/kill", TYPES.kill)
    requests, replies = node.client("/catch_turtle", wire.CATCH_TURTLE)
    killed, gone = node.server("/kill", wire.KILL)
    until(lambda: all(end.matched() for end in (requests, replies, killed, gone)) and kill.ready())
    for number, name in enumerate(("tom", "x" * 100_001), start=7):
        requests.write(requests.handle, number, name)
        (response,) = until(lambda: made.spin() or replies.take())
        assert (response.client, response.number, response.success) == (requests.handle, number, len(name) > 9)
    call = kill.call(Name("tom"))
    (kill_request,) = until(killed.take)
    assert kill_request.name == "tom"
    gone.write(kill_request.client + 1, kill_request.number, 0)
    gone.write(kill_request.client, kill_request.number, 0)
    until(lambda: made.spin() or call.done())


def test_calls_that_no_node_answers_are_forgotten_at_last(ours):
    client = ours[0].client("/silent", TYPES.kill)
    calls = [weakref.ref(client.call(Name("tom"))) for _ in range(SERVICE_DEPTH + 1)]
    gc.collect()
    assert [call() is None for call in calls] == [True] + [False] * SERVICE_DEPTH


def test_what_cannot_be_read_is_left_out_and_the_next_is_heard(ours, domain):
    """With one line for each topic and service; such a request gets no answer."""
    made, log_lines = ours
    received = []
    made.subscribe("/in", TYPES.turtle_array, received.append)
    made.serve("/odd", TYPES.catch_turtle, lambda one: received.append(one.message))
    node = wire.Node(domain)
    turtles, requests = node.writer("rt/in", wire.TURTLES), node.writer("rq/oddRequest", wire.CATCH_TURTLE[0])
    until(lambda: turtles.matched() and requests.matched())
    for _ in range(2):
        turtles.write_bytes(bytes.fromhex("00010000 01000000 03000000 fffe00") + bytes(29))
        requests.write_bytes(bytes.fromhex("00010000") + bytes(16) + bytes.fromhex("02000000 ff00"))
    turtles.write([])
    requests.write(requests.handle, 1, "a")
    until(lambda: made.spin() or len(received) == 2)
    assert received == [TurtleArray(()), CatchTurtleRequest("a")]
    assert sorted(log_lines) == [
        f"warning: a message on {topic} cannot be read (UnicodeDecodeError)" for topic in ("/in", "/odd")
    ]


def test_a_message_that_cannot_be_sent_is_left_out_with_a_line(ours, domain):
    """The next is sent. A target's name may be a stranger's."""
    made, log_lines = ours
    send = made.publisher("/names", TYPES.turtle_array)
    reader = wire.Node(domain).reader("rt/names", wire.TURTLES)
    until(reader.matched)
    for name in ("\ud800", "c"):
        send(TurtleArray((Turtle(name, 1.0, 2.0, 3.0),)))
    (message,) = until(lambda: made.spin() or reader.take() or send(TurtleArray((Turtle("c", 1.0, 2.0, 3.0),))))[:1]
    assert [one.name for one in message.turtles] == ["c"]
    assert [line.partition(" (")[0] for line in log_lines] == ["warning: a message on /names cannot be sent"]


FAST_DDS = (
    "a node with Fast DDS, ROS's default middleware, {}, and services of such nodes do not work over cyclonedds: start "
    "it with RMW_IMPLEMENTATION=rmw_cyclonedds_cpp, or use --bus rclpy or --bus rosbridge"
)


def test_an_answer_waits_for_a_client_whose_reader_is_not_known_yet(ours, domain, monkeypatch):
    """The exercise makes a client for every call; DDS tells of its writer first."""
    made, _ = ours
    made.serve("/late", TYPES.catch_turtle, lambda request: request.answer(CatchTurtleResponse(True)))
    node = wire.Node(domain)
    requests = node.writer("rq/lateRequest", wire.CATCH_TURTLE[0])
    until(requests.matched)
    monkeypatch.setattr(dds_bus, "_REPLY_WAIT_S", 60.0)
    requests.write(requests.handle, 1, "x")
    for _ in range(20):
        made.spin(0.01)
    replies = node.reader("rr/lateReply", wire.CATCH_TURTLE[1])
    (response,) = until(lambda: made.spin() or replies.take())
    assert (response.client, response.number, response.success) == (requests.handle, 1, True)


@pytest.fixture
def stranger(domain, monkeypatch):
    """A node that counts as one with Fast DDS."""
    assert is_fast_dds("010f5432-0000-0000-0000-000000000000")
    node = wire.Node(domain)
    assert not is_fast_dds(str(node.participant.guid))
    for module in (dds_domain, dds_bus):
        monkeypatch.setattr(module, "is_fast_dds", lambda peer: peer == str(node.participant.guid))
    return node


@pytest.mark.parametrize("topic", ["/catch_turtle", "/alive_turtles"])
def test_a_node_with_fast_dds_is_named_once_if_it_calls_or_hears_the_list(ours, stranger, topic):
    """With the ways out. A node that only drives is no news."""
    made, log_lines = ours
    made.subscribe("/turtle1/cmd_vel", TWIST, print)
    made.publisher("/alive_turtles", TYPES.turtle_array)
    made.serve("/catch_turtle", TYPES.catch_turtle, print)
    drives = stranger.writer("rt/turtle1/cmd_vel", wire.TWIST)
    until(lambda: made.spin(0.01) or drives.matched())
    for _ in range(20):
        made.spin(0.01)
    assert log_lines == []
    ends = [
        stranger.client(topic, wire.CATCH_TURTLE)
        if topic == "/catch_turtle"
        else stranger.reader(f"rt{topic}", wire.TURTLES)
        for _ in range(2)
    ]
    until(lambda: made.spin(0.01) or log_lines)
    for _ in range(20):
        made.spin(0.01)
    assert log_lines == [f"warning: {FAST_DDS.format(f'uses {topic}')}"]
    del ends


def test_a_server_with_fast_dds_is_not_called(ours, stranger):
    client = ours[0].client("/served", TYPES.catch_turtle)
    ends = stranger.server("/served", wire.CATCH_TURTLE)
    until(lambda: all(end.matched() for end in ends))
    with pytest.raises(BusError) as error:
        until(client.ready)
    assert str(error.value) == FAST_DDS.format("serves /served")


def test_what_is_missing_is_one_line_that_says_what_to_install(monkeypatch):
    """For each of the back-ends, and if there is none."""
    monkeypatch.setattr(opening, "_import_fault", lambda _: "no module")
    for backend, what in (
        ("cyclonedds", "needs cyclonedds"),
        ("rosbridge", "needs websockets"),
        ("rclpy", "source ROS"),
        (None, r"pip install '\.\[ros\]' in the clone"),
    ):
        with pytest.raises(BusError, match=what) as error:
            open_bus(backend)
        assert "\n" not in str(error.value)


@pytest.mark.parametrize("rclpy", ["is not installed", "is not sourced"])
def test_the_first_that_works_is_taken_and_described(monkeypatch, domain, tmp_path, rclpy):
    monkeypatch.delenv("ROS_DISTRO", raising=False)
    if rclpy == "is not sourced":
        monkeypatch.setenv("ROS_DISTRO", "jazzy")
        (tmp_path / "rclpy").mkdir()
        (tmp_path / "rclpy" / "__init__.py").touch()
        (tmp_path / "rclpy" / "node.py").write_text("raise ImportError('librcl.so')")
        monkeypatch.syspath_prepend(tmp_path)
    log_lines = []
    found = open_bus(log=log_lines.append)
    warning = (
        "warning: ROS is sourced, but rclpy cannot be imported (librcl.so), so cyclonedds is used: make the virtual "
        "environment with ROS's own Python: python3 -m venv --system-site-packages"
    )
    assert log_lines == [warning] * (rclpy == "is not sourced")
    assert opening._import_fault("rclpy")  # an import that failed is no rclpy the next time either
    sys.modules.pop("rclpy", None)
    python = f"Python {sys.version_info.major}.{sys.version_info.minor}"
    line = f"bus: cyclonedds, domain {domain}, {python}, interfaces of my_robot_interfaces"
    assert describe_bus(found, found.interfaces(TYPES)) == line
    found.close()


NOBODYS = 200
"""A domain that this process never joins, so that it is not configured yet."""


@pytest.mark.parametrize(
    ("uri", "why"),
    [
        ("<Nonsense/>", "is CYCLONEDDS_URI right"),
        ("file:///no/such/file.xml", "is CYCLONEDDS_URI right"),
        ("file:///home/käse.xml", r"its configuration is not ASCII\): .* is CYCLONEDDS_URI right"),
    ],
)
def test_a_configuration_that_cannot_be_is_one_line(monkeypatch, uri, why):
    """The lines of cyclonedds say more."""
    monkeypatch.setenv("CYCLONEDDS_URI", uri)
    monkeypatch.setenv("ROS_DOMAIN_ID", str(NOBODYS))
    with pytest.raises(BusError, match=rf"DDS domain {NOBODYS} cannot be joined \(.*{why}") as error:
        open_bus("cyclonedds")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("only", "reach", "expected"),
    [
        ("", "", False),
        ("1", "", True),
        ("", "localhost", True),
        ("0", "LOCALHOST", True),
        ("1", "SUBNET", True),
        ("0", "SUBNET", False),
        ("", "SYSTEM_DEFAULT", False),
    ],
)
def test_the_environment_says_where_others_are_looked_for(only, reach, expected):
    """The older variable comes first, and without multicast this machine is named as a peer."""
    environment = {"ROS_LOCALHOST_ONLY": only, "ROS_AUTOMATIC_DISCOVERY_RANGE": reach, "CYCLONEDDS_URI": "<Own/>"}
    assert is_localhost_only(environment) == expected
    made = configuration(environment)
    assert ('<NetworkInterface address="127.0.0.1" multicast="false"/>' in made) == expected
    assert ('<Peer address="127.0.0.1"/>' in made) == expected
    assert "<MaxSampleSize>131072 B</MaxSampleSize>" in made  # a longer message is left out
    assert made.endswith(",<Own/>")  # the user's own comes last and overrides
