"""Chapter 8 by name: the arena answers as the ROS 2 exercise knows it."""

from random import Random

import numpy as np
import pytest
from oracle.arbiter import judge
from oracle.arithmetic import KILL_DOWN, KILL_REFUSED, draw, fraction, key
from ros.match import Match

from catch_arena import ArenaService, Ruling, Verdict
from catch_arena.errors import ActionError, ConfigError, EpisodeError
from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse, Twist

NAMED = CatchTurtleRequest
POSES = ((2.0, 2.0, 0.0), (2.3, 2.0, 0.0))


def a_service(**overrides):
    settings = {"hunter_poses": POSES, "initial_targets": 0, "spawn_frequency_hz": 0.1} | overrides
    service = ArenaService("duel", **settings)
    service.reset(seed=1)
    return service


@pytest.mark.rule("R8.1")
def test_r8_1_spawn_and_kill_by_name():
    """Names count on; a full arena answers with an empty name; a killed target is gone, and unknown from then on."""
    service = a_service(max_targets=2)

    assert [service.spawn(2.1, 2.0), service.spawn(9.0, 9.0, 1.5), service.spawn(1.0, 1.0)] == [
        "target_turtle_1",
        "target_turtle_2",
        "",
    ]
    assert service.alive_turtles().turtles[1] == ("target_turtle_2", 9.0, 9.0, 1.5)
    assert service.kill("target_turtle_1")
    assert not service.kill("target_turtle_1")
    assert service.spawn(5.0, 5.0) == "target_turtle_3"
    assert [turtle.name for turtle in service.alive_turtles().turtles] == ["target_turtle_2", "target_turtle_3"]

    (ruling,) = service.step(requests=[("hunter_0", NAMED("target_turtle_1"))])

    assert ruling.verdict is Verdict.UNKNOWN_TARGET
    assert service.world.spawned == 2


@pytest.mark.rule("R8.1")
def test_r8_1_a_target_that_prey_plays_is_not_killed_by_name():
    """The service answers as for a name that is not alive; a request for it is judged as before."""
    service = ArenaService("herd")
    service.reset(seed=1)
    published = []
    service.subscribe(published.append)
    played = [target.name for target in service.world.targets if target.prey]

    assert not any(map(service.kill, played))
    assert published == []
    assert set(played) < {turtle.name for turtle in service.alive_turtles().turtles}
    (ruling,) = service.step(requests=[("hunter_0", NAMED(played[0]))])
    assert ruling.verdict is Verdict.OUT_OF_REACH


def test_prey_stands_still():
    """The service takes no Twist for prey, though the engine reads a command for each."""
    service = ArenaService("herd", target_motion="still")
    service.reset(seed=1)
    places = [(target.x, target.y, target.theta) for target in service.world.targets if target.prey]
    for _ in range(20):
        service.step({"hunter_0": Twist(2.0, 4.0)})
        played = [target for target in service.world.targets if target.prey]
        assert [(target.x, target.y, target.theta) for target in played] == places
        assert {(target.linear_velocity, target.angular_velocity) for target in played} == {(0.0, 0.0)}


@pytest.mark.rule("R8.1", "R2.5")
def test_r8_1_twists_drive_within_the_limits():
    """A Twist is in m/s and rad/s; what exceeds the limits is limited; nothing that is not finite moves anybody."""
    service = a_service()
    service.step({"hunter_0": Twist(1.0, 0.0), "hunter_1": Twist(99.0, -99.0)})

    assert service.pose("hunter_0").linear_velocity == 1.0
    assert service.pose("hunter_0").x == pytest.approx(2.0 + 6 * 0.016)
    assert service.pose("hunter_1")[3:] == (2.0, -4.0)

    with pytest.raises(ActionError, match="hunter_1: angular_z must be a finite number, got nan"):
        service.step({"hunter_1": Twist(0.0, float("nan"))})
    with pytest.raises(ActionError, match="unknown hunter 'turtle1'"):
        service.step({"turtle1": Twist(0.0, 0.0)})
    with pytest.raises(ActionError, match="spawn: x must lie in"):
        service.spawn(-1.0, 0.0)
    with pytest.raises(ActionError, match=r"spawn: theta must lie in \[-1000, 1000\], got nan"):
        service.spawn(1.0, 1.0, float("nan"))

    assert service.world.step == 1


def test_the_service_keeps_its_own_settings_and_times():
    """The service needs the whole view, and an episode to act in."""
    with pytest.raises(ConfigError, match="ArenaService sets it"):
        ArenaService(observed_targets=3)
    service = ArenaService("duel", max_cycles=1)
    for call in (lambda: service.spawn(1.0, 1.0), lambda: service.targets_seen("hunter_0")):
        with pytest.raises(EpisodeError, match=r"no episode has begun|call reset\(\)"):
            call()
    service.reset(seed=1)
    assert sorted(service.targets_seen("hunter_0")) == sorted(target.name for target in service.world.targets)
    service.step()

    assert service.over
    assert [ruling.verdict for ruling in service.step(requests=[("hunter_0", NAMED("x"))])] == [Verdict.MATCH_OVER]

    with pytest.raises(EpisodeError, match="the episode is over"):
        service.spawn(1.0, 1.0)


@pytest.mark.rule("R8.4")
def test_r8_4_requests_between_two_steps_are_judged_together_in_the_next():
    """Whoever asks first: the nearer is preferred, on the state that was published last, and both hear in that step."""
    match = Match(hunters=2, hunter_poses=POSES)
    name = match.service.spawn(2.1, 2.0)
    match.drive(match.a, turtle="hunter_0")
    match.drive(match.b, turtle="hunter_1")
    match.tick()
    far = match.request(match.b, name, "/hunter_1/catch_turtle")
    near = match.request(match.a, name, "/hunter_0/catch_turtle")

    assert far.done() is near.done() is False

    shown = match.sent("/hunter_0/pose")[-1]
    match.tick()

    assert (far.result(0), near.result(0)) == (CatchTurtleResponse(False), CatchTurtleResponse(True))
    assert [(one.verdict, one.step, one.distance) for one in match.sent("/rulings")] == [
        ("LOST_CONTEST", 1, 0.2),
        ("GRANTED", 1, 0.1),
    ]
    assert shown[:2] == (2.0, 2.0)

    late = match.request(match.a, name, "/hunter_0/catch_turtle")
    match.tick()

    assert (late.result(0), match.sent("/rulings")[-1].verdict) == (CatchTurtleResponse(False), "ALREADY_CAUGHT")


@pytest.mark.rule("R8.4", "R2.4")
def test_r8_4_the_last_twist_counts_and_is_repeated_until_the_watchdog_drops_it():
    """Given when the step begins, it moves the hunter in the 62 ticks that are at most a second later."""
    match = Match(hunter_poses=((2.0, 2.0, 0.0),), time_limit_s=10)
    match.drive(match.a, 2.0)
    match.drive(match.a, 1.0)
    match.tick(62)

    assert match.hunter().x == pytest.approx(2.0 + 62 * 0.016)
    assert match.hunter().linear_velocity == 1.0

    match.tick(10)

    assert match.hunter().x == pytest.approx(2.0 + 62 * 0.016)
    assert match.hunter().linear_velocity == 0.0


def fails(seed, purpose, rate, *counters):
    """R8.3: whether a fault's draw falls below its rate."""
    drawn = key(seed, purpose)
    for counter in counters:
        drawn = draw(drawn, counter)
    return fraction(drawn) < rate


@pytest.mark.rule("R8.1", "R5.6", "R5.7", "R5.8", "R5.10", "R9.1")
@pytest.mark.parametrize(
    ("policy", "needed"), [("nearest", 1), ("nearest", 2), ("first_come", 1), ("first_come", 2), ("capstone", 1)]
)
@pytest.mark.parametrize("seed", [0, 1, 3])
def test_r8_1_every_request_by_name_is_judged_and_scored_as_the_oracle_judges_it(policy, needed, seed):
    """Names of all kinds, several of one hunter in a step, services that fail: the rulings with their step, the score,
    which counts grants, and who is still alive.
    """
    source, teams = Random(seed), ((0, 2), (1,))
    service = ArenaService(
        hunters=3,
        teams=teams,
        hunters_per_catch=needed,
        hunter_poses=((4.0, 5.0, 0.0), (5.0, 5.0, 0.0), (6.0, 5.0, 0.0)),
        policy=policy,
        reach_m=4.0 * needed,
        initial_targets=6,
        max_targets=9,
        spawn_frequency_hz=4.0,
        faults={"kill_down": 0.2, "kill_refused": 0.3},
    )
    service.reset(seed=seed)
    places, scores = {}, [0, 0, 0]
    met = set()
    for step in range(120):
        before = service.world
        places |= {target.name: (target.x, target.y) for target in before.targets}
        numbers = {target.name: target.number for target in before.targets}
        assert [int(name.rpartition("_")[2]) for name in places] == list(range(1, len(places) + 1))
        wanted = [*[*numbers][:3] * 3**needed, *places, "turtle1", "target_turtle_0", 7, "x" * 300]
        calls = [(source.randrange(3), source.choice(wanted)) for _ in range(source.randrange(7))]
        refused = [name for name, number in numbers.items() if fails(seed, KILL_REFUSED, 0.3, step, number)]
        expected = judge(
            hunters=[(hunter.x, hunter.y) for hunter in before.hunters],
            targets=places,
            requests=calls,
            reach_m=4.0 * needed,
            policy=policy,
            seed=seed,
            step=step,
            caught=places.keys() - numbers.keys(),
            kill_service_up=not fails(seed, KILL_DOWN, 0.2, step),
            kill_refused=refused,
            teams=teams,
            hunters_per_catch=needed,
        )

        rulings = service.step(requests=[(f"hunter_{seat}", NAMED(name)) for seat, name in calls])

        assert rulings == [Ruling(Verdict(verdict), *rest, step=step) for verdict, *rest in expected]
        granted = [ruling for ruling in rulings if ruling.success]
        for ruling in granted:
            scores[ruling.hunter] += 1
        assert [hunter.score for hunter in service.world.hunters] == scores
        stay = [name for name in numbers if name in refused or name not in {ruling.target for ruling in granted}]
        assert [turtle.name for turtle in service.alive_turtles().turtles][: len(stay)] == stay
        met |= {ruling.verdict for ruling in rulings}
    assert met >= {Verdict.MALFORMED, Verdict.SERVICE_DOWN, Verdict.GRANTED}
    if needed == 2:
        assert met >= {Verdict.WAITING_FOR_PARTNER, Verdict.LOST_CONTEST, Verdict.GRANTED}
    elif policy != "capstone":
        assert met >= set(Verdict) - {Verdict.MATCH_OVER, Verdict.HUNTER_INACTIVE, Verdict.WAITING_FOR_PARTNER}


@pytest.mark.rule("R1.4", "R8.2")
def test_r1_4_the_alive_targets_are_published_once_for_all_catches_of_a_step():
    """Two catches, one message; spawns come in one of their own; a step without either says nothing."""
    service = a_service(reach_m=20.0)
    published = []
    service.subscribe(lambda turtles: published.append([turtle.name[-1] for turtle in turtles.turtles]))
    names = [service.spawn(x, 3.0) for x in (1.0, 2.0, 3.0)]
    assert published == [["1"], ["1", "2"], ["1", "2", "3"]]
    published.clear()

    service.step()
    assert published == []

    service.step(requests=[("hunter_0", NAMED(names[0])), ("hunter_1", NAMED(names[1]))])
    assert published == [["3"]]

    service.step(requests=[("hunter_0", NAMED(names[0]))])
    assert published == [["3"]]

    for _ in range(98):  # the timer fires after ten seconds
        service.step()
    assert published == [["3"], ["3", "4"]]

    service.kill(names[2])
    assert published[2:] == [["4"]]


@pytest.mark.rule("R8.1", "R1.7")
def test_r8_1_who_drops_out_is_refused_by_name():
    """The Twists of a dropout move nothing."""
    service = a_service(dropout_rate=1.0)
    service.spawn(2.1, 2.0)
    (ruling,) = service.step({"hunter_0": Twist(2.0, 0.0)}, [("hunter_0", NAMED("target_turtle_1"))])
    assert ruling.verdict is Verdict.HUNTER_INACTIVE
    assert service.pose("hunter_0")[:2] == (2.0, 2.0)


def test_a_name_that_cannot_be_compared_is_malformed():
    service = ArenaService(hunters=2)
    service.reset(seed=1)
    (ruling,) = service.step(requests=[("hunter_0", NAMED(np.array(["a", "b"])))])
    assert ruling.verdict is Verdict.MALFORMED
