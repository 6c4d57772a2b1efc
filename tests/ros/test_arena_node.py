"""The arena's node serves seats and services, and survives whatever other nodes send."""

import math

import pytest
from ros.local import LocalBus
from ros.match import TYPES, Match

from catch_arena.errors import BusError
from catch_arena.messages import CatchTurtleResponse
from catch_arena.policy import View
from catch_arena.replay.comparison import verify
from catch_arena.ros.middleware.bus import Endpoint
from catch_arena.ros.middleware.interfaces import (
    EMPTY,
    TWIST,
    Empty,
    Name,
    SetPenRequest,
    SpawnRequest,
    TwistMessage,
    Vector3,
)
from catch_arena.tournament.players import Players

YES, NO = CatchTurtleResponse(True), CatchTurtleResponse(False)
ONE = ((2.0, 2.0, 0.0),)
TWO = ((2.0, 2.0, 0.0), (2.3, 2.0, 0.0))
BAD = [math.nan, math.inf, -math.inf]


def test_several_seats_have_their_own_names_and_every_hunter_is_seen():
    """turtle1 would be anybody's."""
    match = Match(hunters=2, hunter_poses=TWO)
    match.tick()

    assert "/turtle1/pose" not in match.hub.sent
    assert (len(match.sent("/hunter_0/pose")), len(match.sent("/hunter_1/pose"))) == (1, 1)


@pytest.mark.parametrize("twists", [0, 3])
def test_a_node_that_was_not_remapped_is_told_how_in_one_line(twists):
    """Also one that waits for its pose before it drives; the line names a hunter that nobody drives yet."""
    match = Match(hunters=2, hunter_poses=TWO)
    match.drive(match.a)
    match.tick()
    publish = match.b.publisher("/turtle1/cmd_vel", TWIST)
    for _ in range(twists):
        publish(TwistMessage(Vector3(1.0, 0.0, 0.0), Vector3(0.0, 0.0, 0.0)))
    match.tick(20)
    (line,) = [line for line in match.log_lines if "turtle1" in line]
    assert line == (
        "warning: a node drives turtle1, but no hunter has that name if several seats are for nodes: start it with "
        "--ros-args -r /turtle1/cmd_vel:=/hunter_1/cmd_vel -r /turtle1/pose:=/hunter_1/pose "
        "-r /catch_turtle:=/hunter_1/catch_turtle to drive hunter_1 (p1)"
    )


def test_the_list_of_targets_is_published_when_it_changes_and_once_a_second_besides():
    match = Match(hunter_poses=ONE)
    name = match.service.spawn(2.1, 2.0)
    before = len(match.sent("/alive_turtles"))
    match.request(match.a, name)
    match.tick()

    assert [len(sent.turtles) for sent in match.sent("/alive_turtles")[before:]] == [0, 0]

    match.tick(61)
    assert len(match.sent("/alive_turtles")) == before + 2
    match.tick(2)
    assert len(match.sent("/alive_turtles")) == before + 3


def test_standings_tell_each_hunter_when_a_score_changes_and_once_a_second():
    """Each in a tick of its own, so that no queue of ten overflows."""
    match = Match(hunters=2, hunter_poses=TWO, names=["ann", "bob"])
    match.drive(match.a)
    match.tick(62)
    assert [one.hunter for one in match.sent("/standings")] == ["hunter_0", "hunter_1"]

    match.request(match.a, match.service.spawn(2.0, 2.1), "/hunter_0/catch_turtle")
    match.tick()
    assert [(one.player, one.score, one.rank) for one in match.sent("/standings")[2:4]] == [
        ("ann", 1, 1),
        ("bob", 0, 2),
    ]


def test_team_mates_share_their_teams_rank():
    """R11.1: a team of little hunters is ahead of one great one; each hunter's score stays its own."""
    places = ((2.0, 2.0, 0.0), (8.0, 8.0, 0.0), (2.0, 2.0, 0.0), (8.0, 8.0, 0.0))
    match = Match(hunters=4, hunter_poses=places, teams=((0, 1), (2, 3)))
    for seat, place in ((0, 2.0), (0, 2.0), (2, 2.0), (3, 8.0), (3, 8.0)):
        match.request(match.a, match.service.spawn(place, place), f"/hunter_{seat}/catch_turtle")
        match.tick()

    assert match.node.standings() == ((2, 2, 1, 1), (2, 0, 1, 2))
    assert [(one.score, one.rank) for one in match.sent("/standings")[-4:]] == [(2, 2), (0, 2), (1, 1), (2, 1)]


def test_rulings_tell_verdict_distance_winner_and_clause():
    """R5.6, of each request."""
    match = Match(hunter_poses=ONE)
    name = match.service.spawn(2.2, 2.0)
    match.tick()
    calls = [match.request(match.a, one) for one in (name, name)]
    match.tick()
    calls.append(match.request(match.a, "turtle1"))
    match.tick()

    assert [answer.result(0) for answer in calls] == [YES, NO, NO]
    assert [one[1:9] for one in match.sent("/rulings")] == [
        (1, "hunter_0", name, "GRANTED", True, 0.2, "hunter_0", "R5.4"),
        (1, "hunter_0", name, "DUPLICATE", False, -1.0, "", "R5.2"),
        (2, "hunter_0", "turtle1", "UNKNOWN_TARGET", False, -1.0, "", "R5.2"),
    ]
    assert match.sent("/rulings")[0].time == 0.016


def test_how_often_and_from_how_far_a_node_asked_is_a_remark_after_the_match():
    match = Match(hunters=2, hunter_poses=TWO, names=["anna", "ben"])
    match.drive(match.a)
    match.tick()
    never = "ben: no node drove hunter_1: look for an error in its terminal"
    assert match.node.remarks() == (never,)
    name = match.service.spawn(2.45, 2.0)
    for _ in range(3):
        match.request(match.a, name, "/hunter_0/catch_turtle")
        match.tick()
    match.request(match.a, match.service.spawn(2.0, 4.0), "/hunter_0/catch_turtle")
    match.tick()
    assert match.node.remarks() == (
        "anna: 4 requests from too far, 0.45 to 2.00 m away: a catch needs less than reach_m, 0.3 m",
        never,
    )


def test_a_node_that_asks_for_what_is_gone_is_told_after_ten_times():
    match = Match(hunter_poses=ONE, names=["anna"])
    name = match.service.spawn(2.1, 2.0)
    for _ in range(30):
        match.request(match.a, name)
        match.tick()
    (line,) = match.log_lines
    assert line.startswith("anna has requested targets that are gone 10 times, such as target_turtle_1: choose another")


def test_a_node_without_targets_may_be_silent_and_one_with_targets_may_not():
    match = Match(hunter_poses=ONE)
    match.drive(match.a, 0.0)
    match.tick(200)
    match.drive(match.a, 0.0)
    match.tick()
    assert match.log_lines == ["hunter_0: its node is there"]
    match.service.spawn(9.0, 9.0)
    match.tick(200)
    match.drive(match.a, 0.0)
    match.tick()
    assert match.log_lines[1:] == [
        "hunter_0: its node is silent; the hunter stands still until a node drives it again",
        "hunter_0: its node is back",
    ]


@pytest.mark.parametrize("targets", [0, 1])
@pytest.mark.parametrize("silent_ticks", [3, 100])
def test_a_node_that_drove_and_goes_is_told_once(targets, silent_ticks):
    """Also where there was no target to drive to."""
    match = Match(hunter_poses=ONE)
    for _ in range(targets):
        match.service.spawn(9.0, 9.0)
    there = {"/hunter_0/cmd_vel": 1}
    match.node._bus.publishers_of = lambda topic: there.get(topic, 0)
    match.drive(match.a, 1.0)
    match.tick(silent_ticks)
    there.clear()
    match.tick(100)
    how = "is silent" if targets and silent_ticks > 63 else "has gone"
    assert match.log_lines == [
        "hunter_0: its node is there",
        f"hunter_0: its node {how}; the hunter stands still until a node drives it again",
    ]


@pytest.mark.parametrize("seats", [1, 2])
def test_one_node_may_use_other_names_for_the_list_and_the_service(seats):
    """One that makes its client for each call is seen with the first call, when the match is under way."""
    match = Match(hunters=seats, hunter_poses=TWO[:seats])
    graph = []
    match.node._bus.graph = lambda: graph
    match.tick(70)
    graph += [
        Endpoint("/mine", "subscription", "/turtles", TYPES.turtle_array.name),
        Endpoint("/mine", "client", "/catch_it", TYPES.catch_turtle.name),
    ]
    match.tick(150)
    if seats == 2:  # nobody knows which of them asks
        assert "/catch_it" not in match.hub.served
        assert "-r /turtles:=/alive_turtles -r /catch_it:=/hunter_0/catch_turtle" in match.log_lines[0]
        return
    assert match.log_lines == [
        f"a node uses {name}, so it is served like {usual} (or start it with --ros-args -r {name}:={usual})"
        for name, usual in (("/turtles", "/alive_turtles"), ("/catch_it", "/catch_turtle"))
    ]
    answer = match.request(match.a, match.service.spawn(2.1, 2.0), "/catch_it")
    match.tick()
    assert answer.result(0) == YES
    assert [len(one.turtles) for one in match.sent("/turtles")] == [1, 0]


@pytest.mark.parametrize("seats", [1, 2])
def test_nobody_is_robbed_by_a_kill_from_afar(seats):
    match = Match(hunters=seats, hunter_poses=TWO[:seats])
    near, far = match.service.spawn(2.1, 2.0), match.service.spawn(9.0, 9.0)
    calls = [match.a.client("/kill", TYPES.kill).call(Name(name)) for name in (far, near)]
    match.tick(2)
    assert [answer.result(0) for answer in calls] == [Empty(), Empty()]
    alive = [turtle.name for turtle in match.service.alive_turtles().turtles]
    if seats == 1:  # the first request of the step counts (R5.2)
        assert match.log_lines == [
            "warning: /kill of a target is judged as a request to catch it",
            *match.log_lines[1:],
        ]
        assert [one.verdict for one in match.sent("/rulings")] == ["OUT_OF_REACH", "DUPLICATE"]
        match.a.client("/kill", TYPES.kill).call(Name(near))
        match.tick()
        assert match.sent("/rulings")[-1].verdict == "GRANTED"
    else:
        assert match.log_lines == ["warning: /kill of a target is refused: call /catch_turtle instead"]
    assert alive == [near, far]
    assert match.hunter().score == 2 - seats


def test_a_ruling_says_that_the_hunter_waits_for_a_partner():
    """The service's answer is no; the message on /rulings says why."""
    match = Match(hunters=2, hunter_poses=TWO, teams=((0, 1),), hunters_per_catch=2)
    answer = match.request(match.a, match.service.spawn(2.1, 2.0), "/hunter_0/catch_turtle")
    match.tick()
    assert answer.result(0) == NO
    ruling = match.sent("/rulings")[-1]
    assert (ruling.verdict, ruling.success, ruling.clause, ruling.winner) == ("WAITING_FOR_PARTNER", False, "R5.10", "")
    assert ruling.reason == "too few hunters of its team asked for the target in this step (R5.10)"
    assert ruling.distance > 0


def test_a_new_node_hears_its_pose_for_some_ticks_before_the_list():
    match = Match(hunter_poses=ONE)
    listeners = {"/hunter_0/pose": 0, "/turtle1/pose": 0}
    match.node._bus.listeners_to = listeners.get
    match.tick(100)
    listeners["/turtle1/pose"] = 1
    before = len(match.sent("/alive_turtles"))
    match.tick()
    match.service.spawn(9.0, 9.0)
    match.tick(8)
    assert len(match.sent("/alive_turtles")) == before
    match.tick(2)
    assert [len(one.turtles) for one in match.sent("/alive_turtles")[before:]] == [1]


def test_where_our_own_types_are_not_known_the_rest_is_published(monkeypatch):
    """ROS on the other side may not have our package."""
    publisher = LocalBus.publisher

    def refuse(self, topic, kind):
        if kind.name.startswith("catch_arena_interfaces/"):
            raise BusError(f"{kind.name} is not known to this ROS")
        return publisher(self, topic, kind)

    monkeypatch.setattr(LocalBus, "publisher", refuse)
    match = Match(hunter_poses=ONE)
    answer = match.request(match.a, match.service.spawn(2.1, 2.0))
    match.tick()

    assert answer.result(0) == YES
    assert match.log_lines == []


# who drives, and who asks


def test_the_match_waits_for_seats_without_a_node():
    """A publisher is enough; a Twist is too, where the middleware does not tell who publishes."""
    match = Match(hunters=2, hunter_poses=TWO)
    assert [seat.hunter for seat in match.node.missing] == ["hunter_0", "hunter_1"]

    match.a.publisher("/hunter_0/cmd_vel", TWIST)
    assert [seat.hunter for seat in match.node.missing] == ["hunter_1"]

    match.node._bus.publishers_of = lambda _: None
    match.drive(match.b, turtle="hunter_1")
    match.node.wait()
    assert [seat.hunter for seat in match.node.missing] == ["hunter_0"]


def test_a_seat_whose_node_goes_stands_still_and_may_come_back():
    """The line for it is tested above."""
    match = Match(hunter_poses=ONE, time_limit_s=10)
    match.drive(match.a, 1.0)
    match.tick(3)
    match.a.gone()
    match.tick(60)
    x = match.hunter().x
    match.tick(30)
    assert (match.hunter().linear_velocity, match.hunter().x) == (0.0, x)
    match.drive(match.b, 1.0)
    match.tick()
    assert match.hunter().linear_velocity == 1.0
    assert match.log_lines[-1] == "hunter_0: its node is back"


def test_where_several_seats_are_for_nodes_the_shared_service_says_so():
    """The arena cannot know who asks there; each hunter's own service works."""
    match = Match(hunters=2, hunter_poses=TWO)
    name = match.service.spawn(2.1, 2.0)
    shared, own = match.request(match.a, name), match.request(match.a, name, "/hunter_0/catch_turtle")
    match.tick()

    assert (shared.result(0), own.result(0)) == (NO, YES)
    assert any("/hunter_0/catch_turtle" in line for line in match.log_lines)


def test_a_person_only_drives_and_what_is_in_reach_is_asked_for_them():
    """R4.4: a person drives with turtle_teleop_key."""
    match = Match(hunters=2, hunter_poses=((2.0, 2.0, 0.0), (8.0, 8.0, 0.0)), people=[0])
    first = match.service.spawn(2.5, 2.0)
    match.drive(match.a, 2.0, turtle="hunter_0")
    match.drive(match.b, turtle="hunter_1")
    for _ in range(10):
        match.request(match.b, "nonsense")
        match.tick()

    assert match.hunter(0).score == 1
    assert [(one.hunter, one.target) for one in match.sent("/rulings") if one.success] == [("hunter_0", first)]


# what strangers send


@pytest.mark.parametrize("bad", BAD)
@pytest.mark.parametrize("field", [0, 1])
def test_a_twist_that_is_not_finite_is_left_out(bad, field):
    """The one before it holds, and it is told once."""
    match = Match(hunter_poses=ONE)
    match.drive(match.a, 1.0)
    match.tick()
    for _ in range(3):
        match.drive(match.a, *((bad, 0.0) if field == 0 else (1.0, bad)))
        match.tick()

    assert match.hunter().linear_velocity == 1.0
    assert sum("not finite" in line for line in match.log_lines) == 1


def test_fields_that_turtles_do_not_obey_are_not_read():
    """linear.y among them, as from Iron on; of that a node is told once, as it may steer by it."""
    match = Match(hunter_poses=ONE)
    odd = TwistMessage(Vector3(1.0, math.nan, math.inf), Vector3(math.nan, 5.0, 0.0))
    for _ in range(2):
        match.a.publisher("/hunter_0/cmd_vel", TWIST)(odd)
        match.tick()

    assert match.hunter().linear_velocity == 1.0
    assert match.log_lines[0] == "warning: hunter_0: its node sends linear.y, which turtles ignore: turn instead"
    assert sum("linear.y" in line for line in match.log_lines) == 1


def test_of_a_hunters_requests_in_one_step_only_the_first_four_are_judged():
    """R8.4: the others have their answer at once, whoever else asks is judged, and each step begins anew."""
    match = Match(hunters=2, hunter_poses=TWO)
    for _ in range(2):
        name = match.service.spawn(2.3, 2.1)
        before = len(match.sent("/rulings"))
        flood = [match.request(match.a, "nonsense", "/hunter_0/catch_turtle") for _ in range(300)]
        own = match.request(match.b, name, "/hunter_1/catch_turtle")
        match.tick()
        assert [answer.result(0) for answer in flood] == 300 * [NO]
        assert own.result(0) == YES
        rulings = match.sent("/rulings")[before:]
        assert [one.hunter for one in rulings] == 4 * ["hunter_0"] + ["hunter_1"]
    assert len({one.target for one in rulings}) == 2
    assert not any("several targets" in line for line in match.log_lines)


# the other services


def test_spawn_kill_clear_and_reset_answer_at_once():
    """Spawned targets have the arena's own names; out of bounds they stand at the wall, as in turtlesim."""
    match = Match(hunter_poses=ONE, max_targets=2)

    def call(service, kind, request):
        found = match.a.client(service, kind).call(request)
        match.node.wait()
        return found.result(0)

    places = [(50.0, -7.0, 9.0), (1.0, 1.0, 2000.0), (1.0, 1.0, 3000.0), *[(1.0, 1.0, 0.0)] * 3]
    names = [call("/spawn", TYPES.spawn, SpawnRequest(*place, "tom")).name for place in places]
    assert names == ["target_turtle_1", "", "", "target_turtle_2", "", ""]
    assert match.log_lines == [  # what is odd is told once each
        "warning: /spawn: spawn: theta must lie in [-1000, 1000], got 2000.0",
        "warning: /spawn: the arena is full, with 2 targets: nothing is spawned",
    ]
    assert match.service.alive_turtles().turtles[0][1:3] == (match.service.config.side_m, 0.0)
    assert call("/kill", TYPES.kill, Name("turtle1")) == Empty()
    assert call("/clear", EMPTY, Empty()) == Empty()
    for turtle in ("turtle1", "hunter_0"):
        assert call(f"/{turtle}/set_pen", TYPES.set_pen, SetPenRequest(255, 0, 0, 3, 0)) == Empty()
    match.tick(3)
    assert call("/reset", EMPTY, Empty()) == Empty()
    assert (match.service.world.step, match.service.world.targets) == (0, ())


# recorded matches


def test_a_recorded_match_plays_again_and_nobody_changes_it_from_outside():
    """/spawn and /reset are answered, and do nothing; /kill asks for a target."""
    match = Match(hunter_poses=((5.0, 5.0, 0.0),), initial_targets=8, record=True, time_limit_s=4, reach_m=3.0)
    for service, kind, request in (
        ("/spawn", TYPES.spawn, SpawnRequest(1.0, 1.0, 0.0, "")),
        ("/kill", TYPES.kill, Name("target_turtle_1")),
        ("/reset", EMPTY, Empty()),
    ):
        match.a.client(service, kind).call(request)
    step = 0
    while not match.service.over:
        if step % 6 == 0:
            match.drive(match.a, 2.0, math.sin(step))
        if step % 20 == 10:
            match.request(match.a, "nonsense")
        for turtle in match.service.alive_turtles().turtles[: step % 3]:
            match.request(match.a, turtle.name)
        match.tick()
        step += 1

    assert match.service.world.spawned == 8
    assert match.hunter().score > 0
    assert sum("recorded" in line for line in match.log_lines) == 2
    assert verify(match.service.replay) == []


# agents in other seats


class Chaser:
    """Goes for the nearest."""

    control = "target"

    def __init__(self):
        self.views = []

    def reset(self, seed):
        del seed

    def act(self, view: View):
        self.views.append(view)
        return 1 if view.targets else 0


class Broken(Chaser):
    def act(self, view):
        del view
        return "left"


def settle(match):
    """Let the agents' thread answer."""
    if match.agents._moves is not None:
        match.agents._moves.exception(timeout=10)


def test_agents_play_in_other_seats_and_are_asked_every_100_ms():
    """The catches of agents are judged and published like the catches of nodes."""
    agent = Chaser()
    match = Match(
        hunters=2,
        players=Players({1: agent}),
        hunter_poses=((9.0, 9.0, 0.0), (2.0, 2.0, 0.0)),
        time_limit_s=20,
    )
    name = match.service.spawn(3.0, 2.05)
    for tick in range(125):
        if tick % 2:  # with a request by name in the step, and without
            match.request(match.a, "x")
        match.tick()
        settle(match)

    assert match.hunter(1).score == 1
    assert [one.hunter for one in match.sent("/rulings") if one.verdict == "GRANTED"] == ["hunter_1"]
    assert {one.target for one in match.sent("/rulings") if one.hunter == "hunter_1"} == {name}
    assert len(agent.views) == 20  # 2 s
    assert agent.views[0].limits.control_period_ms == 100
    match.agents.close()


def test_an_agent_that_fails_is_withdrawn_and_the_others_play_on():
    """R1.6, with a line."""
    match = Match(hunters=2, players=Players({1: Broken()}), hunter_poses=TWO, record=True, time_limit_s=2)
    match.drive(match.a, 1.0, turtle="hunter_0")
    for _ in range(5):
        match.tick()
        settle(match)

    assert match.hunter(1).withdrawn
    assert match.hunter(0).linear_velocity == 1.0
    assert any(line.startswith("hunter_1 forfeits and is withdrawn: ") for line in match.log_lines)
    assert match.node.standings() == ((1, 2), (0, 0))
    while not match.service.over:
        match.tick()
    assert verify(match.service.replay) == []
    match.agents.close()
