"""The node in ROS's graph, as another ROS process reads it, which here is one that speaks bytes."""

import gc
import time
from contextlib import contextmanager

import pytest
from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopicDcpsParticipant,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
)
from cyclonedds.core import Policy, Qos
from ros import cdr, wire
from ros.processes import own_domain

from catch_arena.ros.middleware.bus import open_bus
from catch_arena.ros.middleware.dds_peers import announced_hash
from catch_arena.ros.middleware.interfaces import TWIST, Interfaces

TYPES = Interfaces()
TOPIC = "ros_discovery_info"
HASH = "typehash=RIHS01_" + 64 * "a" + ";"


@contextmanager
def domain_with_ours(node="catch_arena"):
    """A domain, our bus in it with one end of each kind, and what it says."""
    with own_domain() as domain:
        said = []
        ours = open_bus("cyclonedds", node=node, domain=domain, localhost=True, log=said.append)
        keep = ours.publisher("/hunter_0/pose", TYPES.pose)
        ours.subscribe("/hunter_0/cmd_vel", TWIST, print)
        ours.serve("/catch_turtle", TYPES.catch_turtle, print)
        ours.client("/spawn", TYPES.spawn)
        yield domain, ours
        del keep
        ours.close()
        del ours
        gc.collect()  # else it is still there for the next test
        assert said == []


class RosProcess:
    """Its part of the topic: it tells of itself, as each does, and hears the others."""

    def __init__(self, domain, size, user):
        self.node = wire.Node(domain)
        kind = wire.participant_entities(size)
        self.tells = self.node.writer(
            TOPIC, kind, Qos(*wire.GRAPH, Policy.History.KeepLast(1), Policy.Userdata(user.encode()))
        )
        self.hears = self.node.reader(TOPIC, kind, Qos(*wire.GRAPH, Policy.History.KeepAll))
        self.waiting = []

    def heard(self, ours, seconds=60.0):
        """The next that comes while our bus spins."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            ours.spin(0.005)
            self.waiting += self.hears.take()
            if self.waiting:
                return self.waiting.pop(0)
        raise AssertionError("it does not come")

    def endpoints(self, builtin, topics, what=lambda one: one.key.bytes):
        """The ids of a participant's readers or writers by topic, as DDS itself announces them; or more of them.

        It waits until these topics are there.
        """
        looking = BuiltinDataReader(self.node.participant, builtin)
        own = self.node.participant.guid
        end = time.monotonic() + 60.0
        found = {}
        while not found.keys() >= set(topics):
            assert time.monotonic() < end, found
            for one in looking.take(100):
                if one.sample_info.valid_data and one.participant_key != own:
                    found[one.topic_name] = what(one)
            time.sleep(0.01)
        return found


def expected(process, size, node):
    """The whole message, made by hand."""
    ours = [
        one
        for one in BuiltinDataReader(process.node.participant, BuiltinTopicDcpsParticipant).take(10)
        if one.key != process.node.participant.guid
    ]
    (participant,) = ours
    (user,) = [policy.data for policy in participant.qos if isinstance(policy, Policy.Userdata)]
    assert user == b"enclave=/;"
    pad = bytes(size - 16)
    writer = cdr.Writer().raw(participant.key.bytes + pad).number("I", 1).text("/").text(node)
    for builtin, topics in (
        (BuiltinTopicDcpsSubscription, ["rt/hunter_0/cmd_vel", "rq/catch_turtleRequest", "rr/spawnReply"]),
        (BuiltinTopicDcpsPublication, ["rt/hunter_0/pose", "rr/catch_turtleReply", "rq/spawnRequest"]),
    ):
        ids = process.endpoints(builtin, topics)
        assert {topic for topic in ids if topic.startswith("r") and topic != TOPIC} == set(topics)
        writer.number("I", 3)
        for topic in topics:
            writer.raw(ids[topic] + pad)
    return writer.whole()


@pytest.mark.parametrize(("size", "user"), [(24, ""), (16, HASH)])
@pytest.mark.parametrize("node", ["catch_arena", "a"])
def test_the_node_is_told_with_all_its_readers_and_writers(size, user, node):
    """Up to Humble, where nobody announces a hash, and from Iron on; by the names that DDS itself has for them."""
    with domain_with_ours(node) as (domain, ours):
        process = RosProcess(domain, size, user)
        assert process.heard(ours) == expected(process, size, node)


def test_where_nobody_is_who_would_hear_it_nothing_is_told():
    """Which of the two layouts would be a guess. The process that comes second hears what the first one has heard."""
    with domain_with_ours() as (domain, ours):
        onlooker = wire.Node(domain)
        looking = BuiltinDataReader(onlooker.participant, BuiltinTopicDcpsPublication)
        end, topics = time.monotonic() + 60.0, set()
        while "rt/hunter_0/pose" not in topics:
            assert time.monotonic() < end, topics
            ours.spin(0.01)
            topics |= {one.topic_name for one in looking.take(100) if one.sample_info.valid_data}
        assert TOPIC not in topics

        first = RosProcess(domain, 16, HASH)
        told = first.heard(ours)
        assert RosProcess(domain, 16, HASH).heard(ours) == told


def test_a_writer_that_is_new_is_told_and_else_it_is_quiet():
    """One message for each change, however often it spins."""
    with domain_with_ours() as (domain, ours):
        process = RosProcess(domain, 16, HASH)
        before = process.heard(ours)
        keep = ours.publisher("/rulings", TWIST)
        after = process.heard(ours)
        assert len(after) == len(before) + 16
        for _ in range(20):
            ours.spin(0.005)
        assert process.hears.take() + process.waiting == []
        del keep


def test_each_topic_announces_the_hash_that_ros_has_for_its_type():
    """From Iron on ROS warns of each topic whose announcement says nothing; these hashes are those of Jazzy's nodes."""
    with domain_with_ours() as (domain, _):
        process = RosProcess(domain, 16, HASH)
        for builtin, topic, told in (
            (
                BuiltinTopicDcpsPublication,
                "rt/hunter_0/pose",
                "739beba26bcba6920404ba722b7b8321348512f92ea5be235c47251940dd8aa9",
            ),
            (
                BuiltinTopicDcpsSubscription,
                "rt/hunter_0/cmd_vel",
                "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
            ),
        ):
            assert process.endpoints(builtin, [topic], announced_hash)[topic] == f"RIHS01_{told}"


def test_two_of_our_own_do_as_the_first_of_ros_does():
    """The second may hear of the first before it hears of ROS: what that one announces is what ROS did."""
    with domain_with_ours("one") as (domain, ours):
        process = RosProcess(domain, 16, HASH)
        process.heard(ours)
        del process
        second = open_bus("cyclonedds", node="two", domain=domain, localhost=True, log=print)
        late = RosProcess(domain, 16, "")
        names = set()
        while len(names) < 2:
            second.spin(0.005)
            told = late.heard(ours)
            reader = cdr.Reader(told)
            reader.at = 16
            assert (reader.number("I"), reader.text()) == (1, "/")
            names.add(reader.text())
        assert names == {"one", "two"}
        second.close()
