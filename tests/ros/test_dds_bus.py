"""Two processes over DDS, on the loopback interface and without multicast: ours, and one that speaks bytes."""

import sys
import time
from types import SimpleNamespace
from uuid import UUID

import pytest
from cyclonedds.core import Policy, Qos
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from ros import cdr, wire
from ros.processes import own_domain, started

from catch_arena.errors import BusError, ConfigError
from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse, Turtle, TurtleArray
from catch_arena.ros.middleware import bus, dds_bus, dds_domain, dds_peers
from catch_arena.ros.middleware.bus import described, open_bus
from catch_arena.ros.middleware.dds_domain import configuration, discovery_of
from catch_arena.ros.middleware.dds_types import dds_name
from catch_arena.ros.middleware.interfaces import TWIST, Interfaces
from catch_arena.ros.middleware.type_hashes import type_hash

TYPES = Interfaces()


def until(ready, seconds=60.0):
    """What `ready` returns once that is something."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = ready()
        if found:
            return found
        time.sleep(0.005)
    raise AssertionError("it does not come")


@pytest.fixture(scope="module")
def domain():
    """The one in which the other process is."""
    with own_domain() as own:
        yield own


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
        for other in (client + 1, client):  # the first is somebody else's
            ends.kill[1].write(cdr.begin(other, number).number("B", 0).whole())
        said = process.communicate(timeout=60)[1]
        assert process.returncode == 0, said
        assert said.count("cannot be read") == 2, said


def heard(echo):
    return cdr.read_turtles(until(echo.out.take)[0])[0]


def called(ends, request):
    """The response to bytes of a request, behind its header."""
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
    """R5.2, R8.4. With a bound in the type instead, others' types would differ from ours, and be matched late."""
    with started("asker.py", domain, "/catch_turtle", 3, 100_001, 2**17, 10_000_001, 5) as process:
        assert process.communicate(timeout=60)[0].split() == ["True", "True", "None", "None", "True"]
    echo.catch[1].take()  # all clients of a service hear its answers


def test_a_zero_byte_in_a_name_ends_nobody(echo):
    """C's strings end there; whether it arrives or not, what follows does."""
    echo.turtles.write(cdr.turtles([("a\0b", 1.0, 2.0, 3.0)]))
    echo.turtles.write(cdr.turtles([("c", 1.0, 2.0, 3.0)]))
    assert (
        "'c'"
        in until(lambda: [name for data in echo.out.take() for name, *_ in cdr.read_turtles(data) if "'c'" in name])[0]
    )


def test_what_cannot_be_sent_is_left_out(domain):
    """With a line; the next is sent."""
    said = []
    ours = open_bus("cyclonedds", domain=domain, localhost=True, log=said.append)
    send = ours.publisher("/names", TYPES.turtle_array)
    reader = wire.Node(domain).reader("rt/names", wire.turtles())
    until(reader.matched)
    send(TurtleArray((Turtle("\ud800", 1.0, 2.0, 3.0),)))

    def sent():
        """The names that came: they are lost as long as our writer does not know the reader."""
        send(TurtleArray((Turtle("c", 1.0, 2.0, 3.0),)))
        return [one[0] for data in reader.take() for one in cdr.read_turtles(data)]

    assert set(until(sent)) == {"c"}
    assert len(said) == 1
    ours.close()


def test_a_call_that_cannot_be_sent_is_left_out_too(domain):
    """A target's name may be a stranger's."""
    said, asked = [], []
    ours = open_bus("cyclonedds", domain=domain, localhost=True, log=said.append)
    ours.serve("/ours", TYPES.catch_turtle, asked.append)
    client = ours.client("/ours", TYPES.catch_turtle)
    until(lambda: client.ready)
    for name in ("\ud800", "c"):
        client.call(CatchTurtleRequest(name))
    until(lambda: ours.spin() or asked)
    assert [one.message.name for one in asked] == ["c"]
    (line,) = said
    assert line.startswith("warning: a message on /ours cannot be sent ('utf-8' codec can't encode")
    ours.close()


def test_a_topic_is_heard_no_more_when_it_was_unsubscribed(domain):
    """Nor do others find a reader of it: the writer sees that it has nobody left."""
    ours = open_bus("cyclonedds", domain=domain, localhost=True, log=print)
    writer = wire.Node(domain).writer("rt/gone", wire.TWIST)
    heard = []
    ours.subscribe("/gone", TWIST, lambda message, _: heard.append(message))
    until(writer.matched)
    writer.write(cdr.twist((1.0, 0, 0), (0, 0, 0)))
    until(lambda: ours.spin() or heard)
    ours.unsubscribe("/gone")
    until(lambda: not writer.matched())
    ours.spin()
    ours.close()


def test_what_is_no_utf8_is_left_out_and_the_next_is_heard(echo):
    """On topics and services, and each is told once; a request that cannot be read has no answer."""
    asks, _ = echo.catch
    for _ in range(2):
        echo.turtles.write(cdr.turtles([(b"\xff\xfe", 1.0, 2.0, 3.0)]))
        asks.write(cdr.begin(asks.handle, 0).text(b"\xff").whole())
    echo.turtles.write(cdr.turtles([("b", 1.0, 2.0, 3.0)]))
    assert "'b'" in heard(echo)[0]
    assert called(echo.catch, lambda writer: writer.text("a")).number("?") is True


@pytest.mark.parametrize(
    "data",
    [b"", b"\x00\x01\x00\x00", b"\x00\x01\x00\x00\xff\xff\xff\xff", cdr.turtles([("abc", 1.0, 2.0, 3.0)])[:-9]],
)
def test_a_truncated_message_never_leaves_its_sender(domain, data):
    """The library on the sender's side refuses what is cut off; the reader's does the same with what others send."""
    node = wire.Node(domain)
    writer = node.writer("rt/turtles", wire.turtles())
    with pytest.raises(AssertionError):
        writer.write(data)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\x00",
        b"\x00\x01\x00\x00",
        b"\x00\x01\x00\x00\xff\xff\xff\xff",
        b"\xff\xff\xff\xff" + 40 * b"x",
        cdr.turtles([("abc", 1.0, 2.0, 3.0)])[:-9],
        cdr.pose((1, 2, 3, 4, 5)),
        cdr.Writer().number("I", 1).number("I", 2**32 - 1).whole(),
        cdr.Writer().number("I", 2**31).text("abc").whole(),
    ],
)
def test_bytes_that_are_no_such_message_are_left_out_and_the_next_is_heard(echo, domain, data):
    """Cut off, of another type, with lengths that cannot be: as packets that no library has looked at."""
    writer = echo.keep.writer("rt/turtles", wire.turtles())
    until(writer.matched)
    writer.write(cdr.turtles([("first", 1.0, 2.0, 3.0)]))
    assert "'first'" in heard(echo)[0]
    writer.inject(domain, 2, data)
    time.sleep(0.05)
    for name in ("taken for the one that was injected", "next"):
        writer.write(cdr.turtles([(name, 1.0, 2.0, 3.0)]))
    until(lambda: any("'next'" in one[0] for sent in echo.out.take() for one in cdr.read_turtles(sent)))


def test_an_injected_message_arrives_where_it_is_whole(echo, domain):
    """So that the test above tests something."""
    writer = echo.keep.writer("rt/turtles", wire.turtles())
    until(writer.matched)
    writer.write(cdr.turtles([("first", 1.0, 2.0, 3.0)]))
    assert "'first'" in heard(echo)[0]
    writer.inject(domain, 2, cdr.turtles([("injected", 1.0, 2.0, 3.0)]))
    assert "'injected'" in heard(echo)[0]


def test_a_foreign_type_on_a_topic_is_told_in_one_line(domain):
    """DDS does not bring them together; whoever wonders why is told the names."""
    said = []
    ours = open_bus("cyclonedds", domain=domain, localhost=True, log=said.append)
    ours.publisher("/alive_turtles", Interfaces().turtle_array)
    theirs = wire.Node(domain)
    theirs.reader("rt/alive_turtles", wire.turtles("robot_msgs"))
    keep = theirs.reader("rt/alive_turtles", wire.turtles("robot_msgs"))

    def look():
        ours.spin()
        return said

    (line,) = until(look)
    assert line == (
        "warning: robot_msgs/msg/TurtleArray is what another node has on /alive_turtles, where we have "
        "my_robot_interfaces/msg/TurtleArray: they do not hear each other; --interfaces and --turtlesim name the "
        "packages"
    )
    del keep
    ours.close()


def endpoint(topic, kind, participant, user=b""):
    key = UUID(bytes=participant + bytes(14))
    return SimpleNamespace(topic_name=topic, type_name=kind, participant_key=key, qos=Qos(Policy.Userdata(user)))


@pytest.fixture
def watch():
    """A watch that looks at what the test shows it, and what it says."""
    said = []
    made = object.__new__(dds_peers.PeerWatch)
    made._expected, made._served, made._warned, made._log = {}, {}, set(), said.append
    made._knows_fast_dds = False
    made.expect("rq/catch_turtleRequest", TYPES.catch_turtle.request)
    made.expect("rq/killRequest", TYPES.kill.request)
    made.expect("rt/alive_turtles", TYPES.turtle_array)
    return made, said


def test_fast_dds_is_told_apart_by_its_ids_where_services_or_lists_are_concerned(watch):
    """One line, with the ways out, however often its nodes appear, and whatever they call."""
    looking, said = watch
    shown = [
        ("rq/catch_turtleRequest", dds_name(TYPES.catch_turtle.request)),
        ("rq/killRequest", dds_name(TYPES.kill.request)),
        ("rt/alive_turtles", dds_name(TYPES.turtle_array)),
        ("rt/other", "U_"),
    ]
    for topic, kind in shown:
        for vendor in (b"\x01\x0f", b"\x01\x10", b"\x01\x0f"):
            looking._check(endpoint(topic, kind, vendor), writes=True)
    (line,) = said
    assert line == (
        "warning: a node with Fast DDS, ROS's default middleware, has to do with /catch_turtle, and its services "
        "cannot be spoken to over cyclonedds: start it with RMW_IMPLEMENTATION=rmw_cyclonedds_cpp, or give --bus "
        "rclpy or --bus rosbridge"
    )


def test_a_node_with_fast_dds_that_only_hears_the_list_is_told_too(watch):
    looking, said = watch
    looking._check(endpoint("rt/turtle1/cmd_vel", dds_name(TWIST), b"\x01\x0f"), writes=True)
    assert said == []
    looking._check(endpoint("rt/alive_turtles", dds_name(TYPES.turtle_array), b"\x01\x0f"), writes=False)
    assert [line.partition(",")[0] for line in said] == ["warning: a node with Fast DDS"]


def test_other_fields_under_the_same_name_are_told_where_a_node_announces_them(watch):
    """From Iron on; older nodes announce nothing, and an equal announcement is no news."""
    looking, said = watch
    name = dds_name(TYPES.turtle_array)
    for announced in (b"", f"typehash={type_hash(TYPES.turtle_array)};".encode()):
        looking._check(endpoint("rt/alive_turtles", name, b"\x01\x10", announced), writes=True)
    assert said == []

    looking._check(
        endpoint("rt/alive_turtles", name, b"\x01\x10", b"a=b;typehash=RIHS01_" + b"0" * 64 + b";"), writes=True
    )
    (line,) = said
    assert "other fields in my_robot_interfaces/msg/TurtleArray, on /alive_turtles" in line
    assert (
        "ours are «my_robot_interfaces/Turtle[] turtles», "
        "in my_robot_interfaces/msg/Turtle «string name; float64 x; float64 y; float64 theta» (RIHS01_000"
    ) in line


def test_readers_of_responses_are_looked_up_once_each():
    """A node that makes a client for every call has hundreds, and to look one up takes longer than to list them all."""
    readers = {handle: f"process {handle % 2}" for handle in range(200)}
    looked_up = []

    def data(handle):
        looked_up.append(handle)
        return None if handle == 7 or handle not in readers else SimpleNamespace(participant_key=readers[handle])

    writer = SimpleNamespace(get_matched_subscriptions=lambda: list(readers), get_matched_subscription_data=data)
    clients = dds_bus._Clients(writer)
    for _ in range(3):
        assert "process 0" in clients
        assert "process 1" in clients
    assert "process 2" not in clients
    assert {looked_up.count(handle) for handle in readers if handle != 7} == {1}
    assert looked_up.count(7) == 7  # it was gone again each time

    readers = {1000: "process 2", **{handle: peer for handle, peer in readers.items() if handle % 2}}
    assert "process 2" in clients
    assert "process 0" not in clients
    assert "process 1" in clients


def test_who_appears_is_looked_at_a_few_at_a_time():
    """A hundred at once would hold up a tick; nobody is left out."""
    waiting = [endpoint(f"rt/other{number}", "U_", b"\x01\x10") for number in range(20)]
    for one in waiting:
        one.sample_info = SimpleNamespace(valid_data=True)
    seen = []

    def take(most):
        taken = waiting[:most]
        del waiting[:most]
        return taken

    looking = object.__new__(dds_peers.PeerWatch)
    looking._appeared, looking._own, looking._expected = [(SimpleNamespace(take=take), True)], None, {}
    looking._check = lambda one, *, writes: seen.append((one, writes))
    counts = []
    for _ in range(4):
        looking.look()
        counts.append(len(seen))
    assert counts == [8, 16, 20, 20]


def test_who_appears_while_cyclonedds_counts_is_listed_the_next_time(monkeypatch, domain):
    """Its lists are as long as the count before; with one more found it reads beyond their end, which ended matches."""
    ours = open_bus("cyclonedds", domain=domain, localhost=True, log=print)
    ours.subscribe("/met", TWIST, print)
    keep = ours.publisher("/met", TWIST)
    ours.serve("/meet", TYPES.catch_turtle, lambda request: request.answer(CatchTurtleResponse(True)))
    client = ours.client("/meet", TYPES.catch_turtle)
    raced = []
    for end, name in ((DataWriter, "_get_matched_subscriptions"), (DataReader, "_get_matched_publications")):
        found = getattr(end, name)

        def count(self, ref, handles, size, found=found, name=name):
            number = found(self, ref, handles, size)
            late = size > 0 and len(raced) % 2 == 0
            raced.extend([name] * (size > 0))
            return number + late

        monkeypatch.setattr(end, name, count)

    assert client.ready
    assert len(ours.publishers_of("/met")) == 1
    call = client.call(CatchTurtleRequest("a"))
    until(lambda: ours.spin() or call.response)
    assert call.response == CatchTurtleResponse(True)
    assert set(raced) == {"_get_matched_subscriptions", "_get_matched_publications"}
    del keep
    ours.close()


@pytest.mark.parametrize("domain", [-1, 233, 10**20])
def test_a_domain_that_cannot_be_is_one_line(domain):
    """DDS has no ports for it."""
    with pytest.raises(ConfigError, match=f"the domain id must be a whole number from 0 to 232, got {domain}"):
        open_bus("cyclonedds", domain=domain)


@pytest.mark.parametrize("word", ["-1", "x", "1.5", "9999", "\u0663", "\u00b2"])
def test_so_is_one_from_the_environment(monkeypatch, word):
    """By its name."""
    monkeypatch.setenv("ROS_DOMAIN_ID", word)
    with pytest.raises(ConfigError, match=f"ROS_DOMAIN_ID must be a whole number from 0 to 232, got {word}"):
        open_bus("cyclonedds")


def test_what_is_missing_is_one_line_that_says_what_to_install(monkeypatch):
    """For each of the back-ends, and where there is none."""
    monkeypatch.setattr(bus, "_is_installed", lambda _: False)
    for backend, what in (
        ("cyclonedds", "needs cyclonedds"),
        ("rosbridge", "needs websockets"),
        ("rclpy", "source ROS"),
    ):
        with pytest.raises(BusError, match=what) as error:
            open_bus(backend)
        assert "\n" not in str(error.value)
    with pytest.raises(BusError, match=r"pip install '\.\[ros\]' in the clone"):
        open_bus()


@pytest.mark.parametrize("rclpy", ["is not installed", "is not sourced"])
def test_the_first_that_works_is_taken_and_described(monkeypatch, domain, tmp_path, rclpy):
    """That is cyclonedds here."""
    monkeypatch.setenv("ROS_LOCALHOST_ONLY", "1")
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
    assert not bus._is_installed("rclpy")  # what was imported in vain is no rclpy the next time either
    sys.modules.pop("rclpy", None)
    python = f"Python {sys.version_info.major}.{sys.version_info.minor}"
    line = f"bus: cyclonedds, domain {domain}, {python}, interfaces of my_robot_interfaces"
    assert described(found, domain, found.interfaces(TYPES)) == line
    found.publisher("/x", TWIST)
    found.close()


NOBODYS = 200
"""A domain in which this process never is: it could be configured."""


@pytest.mark.parametrize(
    ("only", "reach", "expected"),
    [
        ("", "", "subnet"),
        ("1", "", "localhost"),
        ("", "localhost", "localhost"),
        ("0", "LOCALHOST", "localhost"),
        ("1", "SUBNET", "localhost"),
        ("0", "SUBNET", "subnet"),
        ("", "SYSTEM_DEFAULT", "default"),
        ("", "OFF", "default"),
    ],
)
def test_the_environment_says_where_others_are_looked_for(only, reach, expected):
    """As ROS reads it: the older variable comes first, and an unknown range is the narrow one."""
    assert discovery_of({"ROS_LOCALHOST_ONLY": only, "ROS_AUTOMATIC_DISCOVERY_RANGE": reach}) == expected
    assert discovery_of({}) == "subnet"


def test_the_domain_is_configured_before_it_is_joined(monkeypatch):
    """Once in a process."""
    made = []
    monkeypatch.setattr(dds_domain, "_domains", {})
    monkeypatch.setattr(dds_domain, "Domain", lambda *given: made.append(given))
    monkeypatch.setattr(dds_domain, "DomainParticipant", lambda domain, qos: (domain, qos))
    monkeypatch.setenv("CYCLONEDDS_URI", "<Own/>")
    assert [dds_domain.join(7, "subnet", "qos") for _ in range(2)] == [(7, "qos"), (7, "qos")]
    assert made == [(7, configuration("subnet", "<Own/>"))]
    dds_domain.join(8, "default", "qos")
    assert made[1:] == [(8, configuration("default", "<Own/>"))]


@pytest.mark.parametrize("uri", ["<Nonsense/>", "file:///no/such/file.xml"])
def test_a_configuration_that_cannot_be_is_one_line(monkeypatch, uri):
    """Of the user's; cyclonedds says more about it."""
    monkeypatch.setenv("CYCLONEDDS_URI", uri)
    with pytest.raises(BusError, match=f"DDS domain {NOBODYS} cannot be joined .*: is CYCLONEDDS_URI right") as error:
        open_bus("cyclonedds", domain=NOBODYS, localhost=True)
    assert "\n" not in str(error.value)


def test_a_configuration_beyond_ascii_is_one_line(monkeypatch):
    monkeypatch.setenv("CYCLONEDDS_URI", "file:///home/käse.xml")
    with pytest.raises(BusError, match="CYCLONEDDS_URI must be ASCII"):
        open_bus("cyclonedds", domain=NOBODYS, localhost=True)


def test_the_users_own_configuration_comes_last_and_overrides():
    assert configuration("localhost", "<Own/>").endswith(",<Own/>")
    assert "Discovery" not in configuration("default", "")


@pytest.mark.parametrize(("discovery", "alone"), [("subnet", False), ("localhost", True), ("default", False)])
def test_only_this_machine_is_heard_by_its_own_interface(discovery, alone):
    """It has no multicast, so this machine is a peer of its own."""
    made = configuration(discovery, "")
    assert ('<NetworkInterface address="127.0.0.1" multicast="false"/>' in made) == alone
    assert ('<Peer address="127.0.0.1"/>' in made) == alone
