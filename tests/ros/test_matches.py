"""Whole matches of `catch-arena ros serve` with nodes in other processes, over DDS and rosbridge."""

import signal
from itertools import islice

from ros.bridge import running_bridge
from ros.processes import own_domain, started

from catch_arena.replay import Replay
from catch_arena.replay.comparison import verify

ARENA = ("--seed", 5, "--set", "time_limit_s=4", "--set", "initial_targets=16")


def finished(process, seconds=120):
    out, err = process.communicate(timeout=seconds)
    return out, err, process.returncode


def test_a_students_controller_plays_a_whole_match_and_catches(tmp_path):
    """The controller knows the exercise's names and no package of ours."""
    replay = tmp_path / "match.replay"
    with (
        own_domain() as domain,
        started(
            *(None, "ros", "serve", "--seat", "0=ros:ann", "--record", replay, *ARENA), ROS_DOMAIN_ID=str(domain)
        ) as arena,
        started("student.py", domain, "turtle1", "/catch_turtle", 150) as student,
    ):
        out, err, status = finished(arena)
        student.send_signal(signal.SIGTERM)
        result, _, _ = finished(student)
    assert status == 0, err
    assert "bus: cyclonedds" in err
    assert "hunter_0: its node is there" in out
    score = next(int(line.split()[1]) for line in out.splitlines() if line.endswith("ann (hunter_0)"))
    assert score > 0
    assert int(result) == score
    played = Replay.load(replay)
    assert (played.names, played.steps) == (("ann",), 250)
    assert verify(played) == []


def test_a_node_behind_rosbridge_plays_a_match_and_catches():
    """JSON both ways; nobody has DDS."""
    with (
        running_bridge() as (_, url),
        started(None, "ros", "serve", "--bus", url, *ARENA) as arena,
        started(*(None, "ros", "controller", "nearest", "--bus", url, "--service", "/catch_turtle")) as controller,
    ):
        out, err, status = finished(arena)
        controller.send_signal(signal.SIGINT)
        driven, output, _ = finished(controller)
    assert status == 0, err
    caught = driven.count("caught target_turtle_")
    assert caught > 0, output
    assert any(line.split()[:2] == ["1", str(caught)] for line in out.splitlines()), out


def test_our_controller_and_our_spawner_do_the_exercise_in_a_turtlesim():
    """The simulator is the tests' own. The agent is the original's: the oldest target comes first."""
    with (
        own_domain() as domain,
        started("turtlesim.py", domain, 150) as turtlesim,
        started(
            *(None, "ros", "spawner", "--ros-args", "-p", "spawn_frequency:=2"), ROS_DOMAIN_ID=str(domain)
        ) as spawner,
        started(None, "ros", "controller", "first", ROS_DOMAIN_ID=str(domain)) as controller,
    ):
        judged = list(islice((line for line in spawner.stdout if "GRANTED" in line), 3))
        assert len(list(islice((line for line in controller.stdout if "caught target_turtle_" in line), 2))) == 2
        for process in (controller, spawner, turtlesim):
            process.send_signal(signal.SIGINT)
        _, output, status = finished(controller)
        ended = finished(spawner)
    assert [line.split()[3].strip(",") for line in judged] == [f"target_turtle_{number}" for number in (1, 2, 3)], (
        output
    )
    assert (status, ended[2]) == (0, 0), ended[1]  # Ctrl-C is their end
