"""Two processes over DDS, on the loopback interface and without multicast: ours, and one that speaks bytes."""

import sys
import time
from types import SimpleNamespace

import pytest
from ros import cdr, wire
from ros.processes import own_domain, started

from catch_arena.errors import BusError, ConfigError
from catch_arena.messages import CatchTurtleRequest, Turtle, TurtleArray
from catch_arena.ros.middleware import bus, dds_bus, dds_peers
from catch_arena.ros.middleware.bus import described, open_bus
from catch_arena.ros.middleware.dds_domain import configuration, is_localhost_only
from catch_arena.ros.middleware.dds_peers import Peers, is_fast_dds
from catch_arena.ros.middleware.interfaces import TWIST, Interfaces

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
        yield own


@pytest.fixture
def ours(domain):
    """Our bus in this process, and its lines."""
    said = []
    made = open_bus("cyclonedds", domain=domain, log=said.append)
    yield made, said
    made.close()


@pytest.fixture(scope="module")
def echo(domain):
    """Our process, and the ends of a node that speaks bytes with it."""
    node = wire.Node(domain)
    ends = SimpleNamespace(
        twist=node.writer("rt/twist", wire.TWIST),
        turtles=node.writer("rt/turtles", wire.turtles()),
        out=node.reader("rt/out", wire.turtles()),
        catch=node.client("/catch_turtle", wire.catch_turtle()),
        spawn=node.client("/spawn", wire.SPAWN),
        kill=node.server("/kill", wire.KILL),
        keep=node,
    )
    with started("echo.py", domain) as process:
        until(lambda: all(one.matched() for one in (ends.twist, ends.turtles, ends.out, *ends.catch, *ends.spawn)))
        yield ends
        asked = cdr.Reader(until(ends.kill[0].take)[0])
        client, number = asked.number("Q"), asked.number("q")
        assert asked.text() == "end"
        for other in (client + 1, client):  # the first is another client's
            ends.kill[1].write(cdr.begin(other, number).number("B", 0).whole())
        said = process.communicate(timeout=60)[1]
        assert process.returncode == 0, said
        assert said.count("cannot be read") == 2, said


def heard(echo):
    return cdr.read_turtles(until(echo.out.take)[0])[0]


def called(ends, request):
    """Return the response to bytes of a request, after its header."""
    asks, answers = ends
    called.number += 1
    writer = cdr.begin(asks.handle, called.number)
    request(writer)
    asks.write(writer.whole())
    reader = cdr.Reader(until(answers.take)[0])
    assert (reader.number("Q"), reader.number("q")) == (asks.handle, called.number)
    return reader


called.number = 0


def test_topics_arrive_with_who_sent_them(echo):
    """Both ways, read and written by hand on this side."""
    echo.twist.write(cdr.twist((1.5, 0, 0), (0, 0, -2)))
    said = "TwistMessage(linear=Vector3(x=1.5, y=0.0, z=0.0), angular=Vector3(x=0.0, y=0.0, z=-2.0))"
    assert heard(echo) == (said, 0.0, 0.0, 1.0)

    echo.turtles.write(cdr.turtles([("käse", 1.0, 2.0, 3.0)]))
    assert heard(echo)[0] == "TurtleArray(turtles=(Turtle(name='käse', x=1.0, y=2.0, theta=3.0),))"
    echo.turtles.write(cdr.turtles([]))
    assert heard(echo)[0] == "TurtleArray(turtles=())"


def test_services_answer_with_the_header_of_the_request(echo):
    """The client's handle and its number come back, and then the response."""
    assert called(echo.catch, lambda writer: writer.text("abc")).number("?") is True
    assert called(echo.catch, lambda writer: writer.text("")).number("?") is False

    def spawn(writer):
        for value in (1.5, 2.0, 0.0):
            writer.number("f", value)
        writer.text("tom")

    assert called(echo.spawn, spawn).text() == "tom:1.5"


def test_a_name_that_is_too_long_for_the_rules_is_answered_and_one_that_takes_long_to_read_is_left_out(echo, domain):
    """R5.2, R8.4. A bound in the type is no help: others' types differ from ours then."""
    with started("asker.py", domain, "/catch_turtle", 3, 100_001, 2**17, 10_000_001, 5) as process:
        assert process.communicate(timeout=60)[0].split() == ["True", "True", "None", "None", "True"]
    echo.catch[1].take()  # all clients of a service receive its answers


def test_a_text_that_cannot_be_read_is_left_out_and_the_next_is_heard(echo):
    """One line for each topic and service; such a request gets no answer."""
    asks, _ = echo.catch
    for _ in range(2):
        echo.turtles.write(cdr.turtles([(b"\xff\xfe", 1.0, 2.0, 3.0)]))
        asks.write(cdr.begin(asks.handle, 0).text(b"\xff").whole())
    echo.turtles.write(cdr.turtles([("b", 1.0, 2.0, 3.0)]))
    assert "'b'" in heard(echo)[0]
    assert called(echo.catch, lambda writer: writer.text("a")).number("?") is True


@pytest.mark.parametrize(
    ("data", "arrives"),
    [
        (cdr.turtles([("injected", 1.0, 2.0, 3.0)]), True),  # so that the others test something
        (cdr.turtles([("a\0b", 1.0, 2.0, 3.0)]), False),
        (b"", False),
        (b"\xff\xff\xff\xff" + 40 * b"x", False),
        (cdr.turtles([("injected", 1.0, 2.0, 3.0)])[:-9], False),
        (cdr.pose((1, 2, 3, 4, 5)), False),
        (cdr.Writer().number("I", 1).number("I", 2**32 - 1).whole(), False),
    ],
)
def test_bytes_that_are_no_such_message_are_left_out_and_the_next_is_heard(echo, domain, data, arrives):
    """Cut off, of another type, with impossible lengths: as packets that no library has checked."""
    writer = echo.keep.writer("rt/turtles", wire.turtles())
    until(writer.matched)
    writer.write(cdr.turtles([("first", 1.0, 2.0, 3.0)]))
    assert "'first'" in heard(echo)[0]
    writer.inject(domain, 2, data)
    time.sleep(0.05)
    for name in ("taken for the one that was injected", "next"):
        writer.write(cdr.turtles([(name, 1.0, 2.0, 3.0)]))
    names = []

    def has_next():
        names.extend(one[0] for sent in echo.out.take() for one in cdr.read_turtles(sent))
        return any("'next'" in name for name in names)

    until(has_next)
    assert any("'injected'" in name for name in names) == arrives


def test_a_message_or_a_request_that_cannot_be_sent_is_left_out(ours, domain):
    """With a line; the next is sent. A target's name may be a stranger's."""
    made, said = ours
    asked = []
    made.serve("/ours", TYPES.catch_turtle, asked.append)
    client = made.client("/ours", TYPES.catch_turtle)
    send = made.publisher("/names", TYPES.turtle_array)
    reader = wire.Node(domain).reader("rt/names", wire.turtles())
    until(lambda: reader.matched() and client.ready)
    send(TurtleArray((Turtle("\ud800", 1.0, 2.0, 3.0),)))
    for name in ("\ud800", "c"):
        client.call(CatchTurtleRequest(name))

    def sent():
        """Return the names that came: they are lost until our writer knows the reader."""
        send(TurtleArray((Turtle("c", 1.0, 2.0, 3.0),)))
        return [one[0] for data in reader.take() for one in cdr.read_turtles(data)]

    assert set(until(sent)) == {"c"}
    until(lambda: made.spin() or asked)
    assert [one.message.name for one in asked] == ["c"]
    assert [line.partition(" (")[0] for line in said] == [
        f"warning: a message on {topic} cannot be sent" for topic in ("/names", "/ours")
    ]


def test_a_topic_is_heard_no_more_when_it_was_unsubscribed(ours, domain):
    """The writer sees that it has no reader left."""
    made, _ = ours
    writer = wire.Node(domain).writer("rt/gone", wire.TWIST)
    heard = []
    made.subscribe("/gone", TWIST, lambda message, _: heard.append(message))
    until(writer.matched)
    writer.write(cdr.twist((1.0, 0, 0), (0, 0, 0)))
    until(lambda: made.spin() or heard)
    made.unsubscribe("/gone")
    until(lambda: not writer.matched())
    made.spin()


FAST_DDS = (
    "a node with Fast DDS, ROS's default middleware, {}, and its services cannot be spoken to over cyclonedds: start "
    "it with RMW_IMPLEMENTATION=rmw_cyclonedds_cpp, or give --bus rclpy or --bus rosbridge"
)


@pytest.fixture
def fast_dds(domain, monkeypatch):
    """A node that counts as one with Fast DDS."""
    assert is_fast_dds("010f5432-0000-0000-0000-000000000000")
    node = wire.Node(domain)
    assert not is_fast_dds(str(node.participant.guid))
    for module in (dds_peers, dds_bus):
        monkeypatch.setattr(module, "is_fast_dds", lambda peer: peer == str(node.participant.guid))
    return node


@pytest.mark.parametrize("topic", ["/catch_turtle", "/alive_turtles"])
def test_a_node_with_fast_dds_is_named_once_if_it_calls_or_hears_the_list(ours, fast_dds, topic):
    """With the ways out. A node that only drives is no news."""
    made, said = ours
    made.subscribe("/turtle1/cmd_vel", TWIST, print)
    made.publisher("/alive_turtles", TYPES.turtle_array)
    made.serve("/catch_turtle", TYPES.catch_turtle, print)
    drives = fast_dds.writer("rt/turtle1/cmd_vel", wire.TWIST)
    until(lambda: made.spin(0.01) or drives.matched())
    for _ in range(20):
        made.spin(0.01)
    assert said == []
    ends = [
        fast_dds.client(topic, wire.catch_turtle())
        if topic == "/catch_turtle"
        else fast_dds.reader(f"rt{topic}", wire.turtles())
        for _ in range(2)
    ]
    until(lambda: made.spin(0.01) or said)
    for _ in range(20):
        made.spin(0.01)
    assert said == [f"warning: {FAST_DDS.format(f'has to do with {topic}')}"]
    del ends


def test_a_server_with_fast_dds_is_not_called(ours, fast_dds):
    client = ours[0].client("/served", TYPES.catch_turtle)
    ends = fast_dds.server("/served", wire.catch_turtle())
    until(lambda: all(end.matched() for end in ends))
    with pytest.raises(BusError) as error:
        until(lambda: client.ready)
    assert str(error.value) == FAST_DDS.format("serves /served")


def test_processes_are_looked_up_once_for_each_of_their_ends():
    """A node that makes a client for every call has hundreds, and to look one up takes longer than to list them all."""
    readers = {handle: f"process {handle % 2}" for handle in range(200)}
    looked_up = []

    def data(handle):
        looked_up.append(handle)
        return None if handle == 7 else SimpleNamespace(participant_key=readers[handle])

    def handles():
        """Return all, but for the first time: cyclonedds reads beyond its list's end if one is added meanwhile."""
        if not looked_up:
            looked_up.append(None)
            raise IndexError
        return list(readers)

    peers = Peers(SimpleNamespace(get_matched_subscriptions=handles, get_matched_subscription_data=data))
    for _ in range(3):
        assert peers.present() == {"process 0", "process 1"}
    assert {looked_up.count(handle) for handle in readers if handle != 7} == {1}
    assert looked_up.count(7) == 3  # it had left before it was looked up

    readers = {1000: "process 2", **{handle: peer for handle, peer in readers.items() if handle % 2}}
    assert peers.present() == {"process 1", "process 2"}
    assert peers.of(0) == "process 0"  # whose last samples may be read later


@pytest.mark.parametrize("domain", [-1, 233, 10**20])
def test_a_domain_that_cannot_be_is_one_line(domain):
    """DDS has no ports for it."""
    with pytest.raises(ConfigError, match=f"the domain id must be a whole number from 0 to 232, got {domain}"):
        open_bus("cyclonedds", domain=domain)


@pytest.mark.parametrize("word", ["-1", "1.5", "9999", "\u0663"])
def test_so_is_one_from_the_environment(monkeypatch, word):
    """By its name."""
    monkeypatch.setenv("ROS_DOMAIN_ID", word)
    with pytest.raises(ConfigError, match=f"ROS_DOMAIN_ID must be a whole number from 0 to 232, got {word}"):
        open_bus("cyclonedds")


def test_what_is_missing_is_one_line_that_says_what_to_install(monkeypatch):
    """For each of the back-ends, and if there is none."""
    monkeypatch.setattr(bus, "_is_installed", lambda _: False)
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
    """That is cyclonedds here."""
    monkeypatch.delenv("ROS_DISTRO", raising=False)
    if rclpy == "is not sourced":
        monkeypatch.setenv("ROS_DISTRO", "jazzy")
        (tmp_path / "rclpy").mkdir()
        (tmp_path / "rclpy" / "__init__.py").touch()
        (tmp_path / "rclpy" / "node.py").write_text("raise ImportError('librcl.so')")
        monkeypatch.syspath_prepend(tmp_path)
    said = []
    found = open_bus(domain=domain, log=said.append)
    warning = (
        "warning: ROS is sourced, but rclpy cannot be imported (librcl.so), so cyclonedds is used: make the virtual "
        "environment with ROS's own Python: python3 -m venv --system-site-packages"
    )
    assert said == [warning] * (rclpy == "is not sourced")
    assert not bus._is_installed("rclpy")  # an import that failed is no rclpy the next time either
    sys.modules.pop("rclpy", None)
    python = f"Python {sys.version_info.major}.{sys.version_info.minor}"
    line = f"bus: cyclonedds, domain {domain}, {python}, interfaces of my_robot_interfaces"
    assert described(found, domain, found.interfaces(TYPES)) == line
    found.close()


NOBODYS = 200
"""A domain that this process never joins, so that it is not configured yet."""


@pytest.mark.parametrize(
    ("uri", "why"),
    [
        ("<Nonsense/>", f"DDS domain {NOBODYS} cannot be joined .*: is CYCLONEDDS_URI right"),
        ("file:///no/such/file.xml", f"DDS domain {NOBODYS} cannot be joined .*: is CYCLONEDDS_URI right"),
        ("file:///home/käse.xml", "CYCLONEDDS_URI must be ASCII"),
    ],
)
def test_a_configuration_that_cannot_be_is_one_line(monkeypatch, uri, why):
    """The lines of cyclonedds say more."""
    monkeypatch.setenv("CYCLONEDDS_URI", uri)
    with pytest.raises(BusError, match=why) as error:
        open_bus("cyclonedds", domain=NOBODYS)
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
    """As in ROS the older variable comes first. The loopback interface has no multicast, so this machine is a peer."""
    environment = {"ROS_LOCALHOST_ONLY": only, "ROS_AUTOMATIC_DISCOVERY_RANGE": reach, "CYCLONEDDS_URI": "<Own/>"}
    assert is_localhost_only(environment) == expected
    made = configuration(environment)
    assert ('<NetworkInterface address="127.0.0.1" multicast="false"/>' in made) == expected
    assert ('<Peer address="127.0.0.1"/>' in made) == expected
    assert made.endswith(",<Own/>")  # the user's own comes last and overrides
