"""Chapter 8 by names: the arena as the ROS 2 exercise knows it."""

import pytest

from catch_arena import ArenaService, Verdict
from catch_arena.errors import ActionError, ConfigError, EpisodeError
from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse, Twist
from catch_arena.service import response

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


@pytest.mark.rule("R8.1", "R5.1", "R5.2")
def test_r8_1_catch_turtle_by_name_is_the_arbiters_answer():
    """Two near hunters, one turtle: the nearer is told success; then it is caught, and other names are unknown."""
    service = a_service()
    name = service.spawn(2.1, 2.0)
    requests = [("hunter_1", NAMED(name)), ("hunter_0", NAMED(name)), ("hunter_0", NAMED("turtle1"))]
    rulings = service.step(requests=requests)

    assert [ruling.verdict for ruling in rulings] == [Verdict.LOST_CONTEST, Verdict.GRANTED, Verdict.DUPLICATE]
    assert [response(ruling) for ruling in rulings] == [CatchTurtleResponse(ruling.success) for ruling in rulings]
    assert (rulings[0].distance_um, rulings[0].winner) == (200_000, 0)
    assert [hunter.score for hunter in service.world.hunters] == [1, 0]

    later = service.step(requests=[("hunter_0", NAMED(name)), ("hunter_1", NAMED("turtle1"))])

    assert [ruling.verdict for ruling in later] == [Verdict.ALREADY_CAUGHT, Verdict.UNKNOWN_TARGET]

    far = service.spawn(9.0, 9.0)
    (ruling,) = service.step(requests=[("hunter_1", NAMED(far))])

    assert (ruling.verdict, service.world.hunters[1].score) == (Verdict.OUT_OF_REACH, 0)


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

    assert service.world.step == 1


@pytest.mark.rule("R8.1", "R8.3")
def test_r8_1_faults_of_the_arena_reach_the_named_services():
    """With the kill service always down, a request by name is SERVICE_DOWN, and the turtle stays."""
    service = a_service(faults={"kill_down": 1.0})
    name = service.spawn(2.1, 2.0)
    (ruling,) = service.step(requests=[("hunter_0", NAMED(name))])

    assert ruling.verdict is Verdict.SERVICE_DOWN
    assert service.alive_turtles().turtles


def test_the_service_keeps_its_own_settings_and_times():
    """It needs full control and the whole view; and an episode to act in."""
    with pytest.raises(ConfigError, match="must be left to the service"):
        ArenaService(control="target")
    service = ArenaService("duel", max_cycles=1)
    with pytest.raises(EpisodeError):
        service.spawn(1.0, 1.0)
    service.reset(seed=1)
    service.step()

    assert service.over
    assert [ruling.verdict for ruling in service.step(requests=[("hunter_0", NAMED("x"))])] == [Verdict.MATCH_OVER]

    with pytest.raises(EpisodeError, match="under way"):
        service.spawn(1.0, 1.0)
