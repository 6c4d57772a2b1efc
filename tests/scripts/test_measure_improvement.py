"""scripts/measure_improvement.py: what it plays, and that a future is a future of the arena it was copied from."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

PATH = Path(__file__).parents[2] / "scripts/measure_improvement.py"


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("measure_improvement", PATH)
    made = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = made
    spec.loader.exec_module(made)
    yield made
    del sys.modules[spec.name]


@pytest.fixture
def arenas(script):
    """Three arenas after a second, with the network's player."""
    made = script.Arenas(3)
    made.engine.reset([5, 6, 7])
    made.seat(np.array([[0, 1, 2, 3], [1, 2, 3, 0], [3, 0, 2, 1]]))
    player = script.Player(script.parse_options([]))
    for _ in range(10):
        alone(script, player, made)
    return made


def alone(script, player, arenas):
    """A step in which the network plays."""
    view, nothing = arenas.seen_by(0), np.zeros((5, len(arenas.rows)))
    goal = player.goals(view, 1)[:, :, 0]
    arenas.step(script.velocities(view, nothing, script.follow(view, nothing), goal))


def test_it_prints_what_the_player_wins_and_which_courses_were_best(script, capsys):
    families = ",".join(script.FAMILIES[2:])
    script.measure(
        script.parse_options(
            ["--matches=2", "--every=100", "--steps=5", "--first=2", "--second=2", f"--courses={families}"]
        )
    )
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[1:4]] == ["alone", "thinks", "gain"]
    shares = [float(line.split(" % of thoughts")[0].split()[-1]) for line in lines[4:]]
    assert sum(shares) == pytest.approx(100, abs=len(shares))


def test_a_copy_with_the_same_seeds_goes_on_as_its_arena_does(script, arenas):
    copy, player = script.Arenas(4), script.Player(script.parse_options([]))
    copy.take(arenas, np.array([2, 0, 0, 1]), None)
    for _ in range(40):
        alone(script, player, copy)
        alone(script, player, arenas)
    assert copy.scores().tolist() == arenas.scores()[[2, 0, 0, 1]].tolist()
    assert copy.engine.observations.tolist() == arenas.engine.observations[[2, 0, 0, 1]].tolist()


def test_only_targets_to_come_differ_between_futures(script, arenas):
    copy, player = script.Arenas(4), script.Player(script.parse_options([]))
    copy.take(arenas, np.zeros(4, np.int64), np.array([[1, 1, 2, 3], [4, 4, 5, 6]]))
    assert (copy.engine.observations == arenas.engine.observations[0]).all()
    for _ in range(30):
        alone(script, player, copy)
    first, second, *rest = copy.engine.observations
    assert (first == second).all()
    assert all((first != other).any() for other in rest)


def test_futures_do_not_depend_on_how_many_are_played_at_once(script, arenas, monkeypatch):
    ways = np.zeros((5, 3, 2))
    worths = []
    for most in (1, 2048):
        monkeypatch.setattr(script, "MOST_COPIES", most)
        player = script.Player(script.parse_options([]))
        worths.append(player.futures(arenas, ways, 2, 10).tolist())
    assert worths[0] == worths[1]
    assert np.ptp(worths[0], axis=2).max() == 0  # both courses are the network's


def test_a_course_that_is_at_an_end_becomes_the_networks(script, arenas):
    view = arenas.seen_by(0)
    x, y = script.to_arena(view, np.array([[1.0]] * 3), np.array([[0.5]] * 3))
    forward, left = script.to_own(view, x[:, 0], y[:, 0])
    assert forward == pytest.approx([1.0] * 3)
    assert left == pytest.approx([0.5] * 3)
    now = np.stack([np.array([script.TARGET, script.PASS, script.REST]), x[:, 0], y[:, 0], np.full(3, 2), np.zeros(3)])
    script.follow(view, now)
    assert now[script.KIND].tolist() == [script.NETWORK, script.PASS, script.REST]  # there is no such target
    script.follow(view, now)
    script.follow(view, now)
    assert now[script.KIND].tolist() == [script.NETWORK] * 3


def test_an_unknown_family_is_refused(script, capsys):
    with pytest.raises(SystemExit):
        script.parse_options(["--courses=places,elsewhere"])
    assert "--courses must be some of places" in capsys.readouterr().err
