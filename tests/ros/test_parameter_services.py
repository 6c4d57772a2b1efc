"""`ros2 param` at our nodes: each a process of its own, asked by one that knows the wire alone."""

import math
import signal
import time

import pytest
from ros import cdr, wire
from ros.parameter_client import BOOL, DOUBLE, INTEGER, STRING, ParameterClient, put_value
from ros.processes import own_domain, started

from catch_arena.replay import Replay
from catch_arena.replay.verification import verify

FREQUENCY, PREFIX, CLOSEST = "spawn_frequency", "turtle_name_prefix", "catch_closest_turtle_first"


@pytest.fixture(scope="module")
def domain():
    """The spawner's."""
    with own_domain() as domain:
        yield domain


@pytest.fixture(scope="module")
def spawner(domain):
    """Ours, in a turtlesim of the tests' own: a client of its parameters, and what it says is alive."""
    with started("turtlesim.py", domain, 240):
        given = ("--ros-args", "-p", f"{FREQUENCY}:=0.001", "--param", f"{PREFIX}:=bob_", "-r", "__node:=referee")
        with started(None, "ros", "spawner", "--domain", domain, *given) as process:
            client = ParameterClient(domain, "referee")
            client.alive = wire.Node(domain).reader("rt/alive_turtles", wire.turtles())
            client.process = process
            yield client
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=60)
            assert "Traceback" not in err
            assert out.count(f"{FREQUENCY}: 50\n") == 1


def test_parameters_are_listed_described_and_told(spawner):
    """With the values of --ros-args, under the node's new name."""
    assert spawner.list() == [FREQUENCY, PREFIX]
    assert spawner.list(PREFIX, "x") == [PREFIX]
    assert spawner.list("spawn") == []
    assert spawner.get(PREFIX, FREQUENCY) == [(STRING, "bob_"), (DOUBLE, 0.001)]
    assert spawner.types(FREQUENCY, PREFIX, FREQUENCY) == [DOUBLE, STRING, DOUBLE]
    assert spawner.describe(FREQUENCY, PREFIX) == [
        (FREQUENCY, DOUBLE, "targets a second; 0 and less is one every 5 s", "", False),
        (
            PREFIX,
            STRING,
            "what the targets' names begin with",
            "the targets that are there have it in their names",
            True,
        ),
    ]


def test_what_is_not_known_has_an_empty_answer(spawner):
    """As rclpy's nodes give it, also where others are asked for beside it."""
    for names in (["x"], [FREQUENCY, ""], ["x" * 100_000], [FREQUENCY] * 15 + [f"/{FREQUENCY}"]):
        assert (spawner.get(*names), spawner.types(*names), spawner.describe(*names)) == ([], [], [])
    assert spawner.get() == []


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ((FREQUENCY, INTEGER, 2), f"{FREQUENCY} must be a double, as 2.0, got 2"),
        ((FREQUENCY, STRING, "2.0"), f"{FREQUENCY} must be a double, as 2.0, got '2.0'"),
        ((FREQUENCY, BOOL, True), f"{FREQUENCY} must be a double, as 2.0, got True"),
        ((FREQUENCY,), f"{FREQUENCY} must be a double, as 2.0, got None"),
        ((FREQUENCY, 255), f"{FREQUENCY} must be a double, as 2.0, got None"),
        ((FREQUENCY, 8, None, ((), (), (), (2.0, 3.0), ())), f"{FREQUENCY} must be a double, as 2.0, got (2.0, 3.0)"),
        ((FREQUENCY, DOUBLE, math.nan), f"{FREQUENCY}: spawn_frequency_hz must be a finite number"),
        ((FREQUENCY, DOUBLE, math.inf), f"{FREQUENCY}: spawn_frequency_hz must be a finite number"),
        ((FREQUENCY, DOUBLE, 1e300), f"{FREQUENCY}: spawn_frequency_hz must be"),
        ((PREFIX, STRING, "ann_"), f"{PREFIX} cannot be changed: the targets that are there have it in their names"),
        ((PREFIX, STRING, "x" * 100_000), f"{PREFIX}: turtles' names must be letters"),
        (("spawn_freqency", DOUBLE, 2.0), f"there is no parameter 'spawn_freqency': did you mean {FREQUENCY}?"),
        (("x" * 100_000, DOUBLE, 2.0), "there is no parameter 'xxxxx"),
        (("\x1b[31m\n", DOUBLE, 2.0), "there is no parameter '\\x1b[31m\\n'"),
        (("", DOUBLE, 2.0), f"there is no parameter '': known: {FREQUENCY}, {PREFIX}"),
    ],
)
@pytest.mark.parametrize("service", ["set_parameters", "set_parameters_atomically"])
def test_what_cannot_be_set_is_refused_in_one_line(spawner, change, why, service):
    """And all is as it was."""
    ((done, reason),) = spawner.set(change, service=service)
    assert not done
    assert reason.startswith(why)
    assert len(reason) <= 300
    assert reason.isprintable()
    assert spawner.get(FREQUENCY, PREFIX) == [(DOUBLE, 0.001), (STRING, "bob_")]


@pytest.mark.parametrize("service", ["get_parameters", "get_parameter_types", "describe_parameters"])
def test_a_list_that_no_node_needs_is_left_out_and_the_next_request_is_answered(spawner, service):
    """More than 16 names would take long to read, and the node has other things to do."""
    empty = cdr.struct.pack("<II", 1, 0)
    for count in (17, 1_000_000):
        spawner.ask(service, lambda writer, count=count: writer.number("I", count).raw(empty * count))
        assert spawner.answer(service, 0.5) is None
    assert spawner.names(service, [""] * 16).number("I") == 0


@pytest.mark.parametrize(("count", "answered"), [(3, True), (16, True), (17, False), (10_000, False)])
@pytest.mark.usefixtures("spawner")
def test_so_is_an_array_that_no_parameter_is(domain, count, answered):
    """In a packet of its own, which no library on this side has looked at."""
    kinds = wire.parameter_services()["set_parameters"]
    node = wire.Node(domain)
    asks, answers = node.client("/referee/set_parameters", kinds)
    while not (asks.matched() and answers.matched()):
        time.sleep(0.01)

    def request(number, *value):
        return put_value(cdr.begin(asks.handle, number).number("I", 1).text(FREQUENCY), *value).whole()

    def answer(seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for data in answers.take():
                reader = cdr.Reader(data)
                if reader.number("Q") == asks.handle:
                    return reader.number("q")
            time.sleep(0.005)
        return None

    asks.write(request(1, DOUBLE, 0.001))
    assert answer(60) == 1
    asks.inject(domain, 2, request(2, 6, None, ((), (True,) * count, (), (), ())))
    assert answer(60 if answered else 0.5) == (2 if answered else None)
    for number in (3, 4):  # the first may be taken for the one that was injected
        asks.write(request(number, DOUBLE, 0.001))
    assert answer(60) in {3, 4}


def test_one_wrong_value_of_several_changes_nothing_where_all_or_none_is_asked_for(spawner):
    """Else each is for itself."""
    wrong = (PREFIX, STRING, "ann_")
    both = (FREQUENCY, DOUBLE, 0.002), wrong
    ((done, _),) = spawner.set(*both, service="set_parameters_atomically")
    assert not done
    assert spawner.get(FREQUENCY) == [(DOUBLE, 0.001)]
    assert [done for done, _ in spawner.set(*both)] == [True, False]
    assert spawner.get(FREQUENCY) == [(DOUBLE, 0.002)]
    assert spawner.set((FREQUENCY, DOUBLE, 0.001), service="set_parameters_atomically") == [(True, "")]
    assert spawner.set() == []


def test_a_running_spawner_goes_on_at_its_new_frequency(spawner):
    """Before it there is no target for a quarter of an hour; the names begin as they were told to."""
    assert spawner.set((FREQUENCY, DOUBLE, 50.0)) == [(True, "")]
    assert spawner.get(FREQUENCY) == [(DOUBLE, 50.0)]
    end, names = time.monotonic() + 60, []
    while len(names) < 5:
        assert time.monotonic() < end, names
        for data in spawner.alive.take():
            names = [name for name, *_ in cdr.read_turtles(data)]
        time.sleep(0.01)
    assert names[:5] == [f"bob_{number}" for number in range(1, 6)]


def test_a_match_keeps_its_settings(tmp_path):
    """They are shown, and setting one is refused with the reason; the replay has those that the arena began with."""
    (tmp_path / "both.yaml").write_text(
        f"/**:\n  ros__parameters:\n    {FREQUENCY}: 8.0\n    {PREFIX}: z_\n"
        f"catch_arena:\n  ros__parameters:\n    {FREQUENCY}: 4.0\n    use_sim_time: false\n"
    )
    replay = tmp_path / "match.replay"
    settings = ("--set", "time_limit_s=1", "--record", replay)
    given = ("--ros-args", "--params-file", tmp_path / "both.yaml", "--", "--seed", 3)
    with own_domain() as domain, started(None, "ros", "serve", "--domain", domain, *settings, *given) as arena:
        client = ParameterClient(domain, "catch_arena")
        assert client.get(FREQUENCY, PREFIX) == [(DOUBLE, 4.0), (STRING, "z_")]
        *refused, unknown = client.set((FREQUENCY, DOUBLE, 1.0), (PREFIX, STRING, "y"), (CLOSEST, BOOL, True))
        for name, (done, reason) in zip((FREQUENCY, PREFIX), refused, strict=True):
            assert not done
            assert reason.startswith(f"{name} cannot be changed: a match keeps its settings")
        assert unknown == (False, f"there is no parameter '{CLOSEST}': known: {FREQUENCY}, {PREFIX}")
        assert [told[-1] for told in client.describe(FREQUENCY, PREFIX)] == [True, True]
        assert client.get(FREQUENCY, PREFIX) == [(DOUBLE, 4.0), (STRING, "z_")]
        keep = wire.Node(domain).writer("rt/turtle1/cmd_vel", wire.TWIST)  # the match begins
        out, err = arena.communicate(timeout=60)
        del keep
    assert arena.returncode == 0, out + err
    assert "catch_arena has 'use_sim_time', which is no parameter of catch_arena: it is left out" in err
    played = Replay.load(replay)
    assert (played.config.spawn_frequency_hz, played.config.name_prefix) == (4.0, "z_")
    assert verify(played) == []


def test_a_controller_has_the_exercises_parameter():
    """It chooses between two agents, of which one was named."""
    given = ("--ros-args", "-p", f"{CLOSEST}:=false")
    with own_domain() as domain, started(None, "ros", "controller", "nearest", "--domain", domain, *given) as process:
        client = ParameterClient(domain, "turtle_controller")
        assert client.get(CLOSEST) == [(BOOL, False)]
        assert client.set((CLOSEST, BOOL, True)) == [(True, "")]
        assert client.get(CLOSEST) == [(BOOL, True)]
        process.send_signal(signal.SIGINT)
        assert "Traceback" not in process.communicate(timeout=30)[1]
