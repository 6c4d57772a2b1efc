"""Teams and prey in pictures: what tells them apart, and where their scores stand."""

import numpy as np
import pytest
from render.matches import played
from render.pictured import SIZES, assert_inside, assert_texts_apart, kinds

from catch_arena.config import ArenaConfig
from catch_arena.render import hud, scene
from catch_arena.render.annotations import annotations_of
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.raster import Canvas
from catch_arena.render.shapes import INK, WHITE, Box, Label, Ring, Turtle
from catch_arena.render.sprites import SpriteCache
from catch_arena.render.standings_animation import StandingsAnimation, standings_shapes
from catch_arena.render.team_scores import team_scores_shapes
from catch_arena.render.timing import Clip
from catch_arena.render.video import rendered_frames, renderer_for
from catch_arena.render.viewport import TARGET, Viewport
from catch_arena.replay.motion import poses_of, step_motion
from catch_arena.verdicts import Ruling, Verdict
from catch_arena.world import HunterState, PreyState, TargetState, World


def a_hunt(*, out: bool = False, withdrawn: bool = False, rulings=(), step: int = 5) -> World:
    """Two hunters, prey that plays target 7 or is out, and another target."""
    hunters = tuple(HunterState(f"hunter_{i}", x, 2.0, 0.5, 1.0, 0.0, i, team=i) for i, x in enumerate((1.0, 9.0)))
    targets = (TargetState("target_turtle_9", 9, 5.0, 5.0, 1.0, 480),)
    if not out:
        targets = (TargetState("target_turtle_7", 7, 3.0, 6.0, 0.0, 0, 0.0, 2.0, prey="prey_0"), *targets)
    prey = PreyState("prey_0", None if out else "target_turtle_7", 2 + out, 400 if out else None, withdrawn=withdrawn)
    return World(100 * step, step, 11.088889122009277, hunters, targets, rulings, 9, (prey,))


def shapes_of(world: World, *, withdrawn_prey=(), **names) -> list:
    info = MatchInfo.of(ArenaConfig(hunters=2, prey=1), **names)
    return scene.arena_shapes(
        Viewport(720, 720, world.side_m),
        info,
        hunters=world.hunters,
        poses=poses_of(world),
        targets=world.targets,
        annotations=(),
        time_ms=5000.0,
        withdrawn_prey=withdrawn_prey,
    )


def test_prey_is_a_larger_and_darker_target_in_a_ring_of_pieces_with_its_number():
    shapes = shapes_of(a_hunt())
    prey, other = (turtle for turtle in kinds(shapes, Turtle) if turtle.color == TARGET)
    assert prey.length > other.length
    assert prey.contrast > other.contrast
    (ring,) = (ring for ring in kinds(shapes, Ring) if ring.pieces == scene.PREY_PIECES)
    assert (ring.x, ring.y) == (prey.x, prey.y)
    assert ring.radius > prey.length / 2
    label = next(label for label in kinds(shapes, Label) if label.text == "P0")
    assert (label.color, label.outline) == (INK, WHITE)  # the other way round than on hunters
    assert (label.x, label.y) == pytest.approx((prey.x, prey.y), abs=1.0)


def test_prey_that_is_out_is_not_in_the_arena():
    texts = {label.text for label in kinds(shapes_of(a_hunt(out=True)), Label)}
    assert texts == {"0", "1"}


def test_withdrawn_prey_is_faded_and_has_no_ring():
    shapes = shapes_of(a_hunt(withdrawn=True), withdrawn_prey={2})
    assert [turtle.faded for turtle in kinds(shapes, Turtle)] == [True, False, False, False]
    assert not [ring for ring in kinds(shapes, Ring) if ring.pieces > 1]


def test_the_second_seat_of_an_agent_has_its_circle_in_two_pieces():
    rings = kinds(shapes_of(a_hunt(out=True), names=("a", "a", "p")), Ring)
    assert [ring.pieces for ring in rings] == [1, 2]


@pytest.mark.parametrize("pieces", [1, 2, 3, 8])
def test_a_ring_in_pieces_has_as_many_gaps(pieces):
    canvas = Canvas.blank(80, 80, (0, 0, 0), SpriteCache())
    canvas.draw([Ring(40.0, 40.0, 30.0, 3.0, WHITE, pieces=pieces)])
    around = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False) + 0.01
    x, y = (np.rint(39.5 + 30.0 * part).astype(int) for part in (np.cos(around), np.sin(around)))
    bright = canvas.pixels[y, x, 0] > 120
    assert np.count_nonzero(bright & ~np.roll(bright, 1)) == (0 if pieces == 1 else pieces)


def test_prey_that_returns_at_a_steps_end_is_out_until_then():
    world = a_hunt()
    born_ms = next(target.spawned_ms for target in world.targets if target.prey)
    for time_ms, out in ((born_ms - 1.0, True), (born_ms, False)):
        assert hud.standings_of(world, time_ms)[-1].out == out


def test_prey_stands_below_the_hunters_the_seldomest_caught_first_and_is_said_to_be_out():
    standings = (*hud.standings_of(a_hunt(out=True)), hud.AgentScore(3, 0, hunted=True))
    assert [one.agent for one in hud.ranked(standings)] == [1, 0, 3, 2]
    animation = StandingsAnimation()
    animation.record(0.0, standings)
    info = MatchInfo.of(ArenaConfig(hunters=2, prey=2))
    area = hud.Rect(0, 0, 500, 250)
    shapes = standings_shapes(area, info, animation.lines(0.0), 1.0)
    rows = {label.text: label.y for label in kinds(shapes, Label)}
    assert rows["hunter_1"] < rows["hunter_0"] < rows["prey_1"] < rows["prey_0  (out)"]
    assert {"P0", "P1", "caught"} <= rows.keys()
    assert [box for box in kinds(shapes, Box) if box.color == info.color(2)] == []  # no bar for prey
    assert_inside(shapes, area)


def test_whoever_catches_prey_is_told_with_it():
    ruling = Ruling(Verdict.GRANTED, 1, "target_turtle_7", 200_000, 1, 5)
    (annotation,) = annotations_of(a_hunt(), a_hunt(out=True, rulings=(ruling,), step=6))
    assert (annotation.seat, annotation.prey) == (1, 2)
    ruling = Ruling(Verdict.GRANTED, 1, "target_turtle_9", 200_000, 1, 5)
    (annotation,) = annotations_of(a_hunt(), a_hunt(rulings=(ruling,), step=6))
    assert annotation.prey is None


def test_prey_that_only_turns_glides_to_its_new_heading():
    """Its world's angular velocity is 2 rad/s; nothing else moves."""
    motion = step_motion(a_hunt(step=4), a_hunt(step=5))
    headings = [poses.targets[7][2] for poses in motion.poses]
    assert np.diff(headings) == pytest.approx(2.0 * 0.016)


TEAMS = {2: ((0, 1), (2, 3)), 4: ((0, 1), (2, 3), (4, 5), (6, 7)), 8: tuple((2 * k, 2 * k + 1) for k in range(8))}


@pytest.mark.parametrize("teams", TEAMS)
@pytest.mark.parametrize("size", SIZES)
def test_the_teams_scores_fit_their_card(size, teams):
    hunters = 2 * teams
    names = [f"contested_by_arrival_time_v{seat // 2}" for seat in range(hunters)]
    info = MatchInfo.of(ArenaConfig(hunters=hunters, teams=TEAMS[teams]), names)
    plan = hud.arrange(size, "broadcast", hunters, teams)
    scores = [41, 142, *range(teams - 2)]
    shapes = team_scores_shapes(plan.teams, info, scores, plan.unit)
    assert_inside(shapes, plan.teams)
    assert_texts_apart(shapes)
    assert {str(score) for score in scores} <= {label.text for label in kinds(shapes, Label)}


def test_two_teams_are_told_with_the_lead_and_the_share_of_each():
    info = MatchInfo.of(ArenaConfig(teams=TEAMS[2]), ("amber_agent", "amber_agent", "b", "b"))
    area = hud.Rect(0, 0, 520, 132)
    shapes = team_scores_shapes(area, info, (30, 10), 1.0)
    assert {"AMBER_AGENT", "B", "30", "10", "catches", "amber_agent +20"} == {one.text for one in kinds(shapes, Label)}
    bars = [box for box in kinds(shapes, Box) if box.color in {hud.legible(team.color) for team in info.contenders}]
    assert bars[0].width / bars[1].width == pytest.approx(3.0, rel=0.05)


@pytest.mark.parametrize("size", SIZES)
def test_the_line_over_the_arena_has_the_teams_scores_and_then_prey(size):
    info = MatchInfo.of(ArenaConfig(prey=2, teams=TEAMS[2]))
    strip, _ = hud.split_strip(hud.arrange(size, "arena", 6, 2).header, "59.9")
    standings = [hud.AgentScore(seat, 9) for seat in range(4)]
    standings += [hud.AgentScore(agent, 3, hunted=True) for agent in (4, 5)]
    shapes = hud.chip_shapes(strip, info, (41, 42), standings)
    assert_inside(shapes, strip)
    assert_texts_apart(shapes)
    texts = [label.text for label in kinds(shapes, Label)]
    assert {"41", "42"} <= set(texts)
    assert "P0" in texts or strip.width < 400


@pytest.mark.parametrize("layout", ["broadcast", "arena"])
def test_a_match_of_teams_and_prey_is_drawn_and_its_leader_is_a_team(layout):
    replay = played("pairs", prey=2, target_motion="wander", prey_returns_s=0.5, time_limit_s=6.0, reach_m=0.8)
    renderer = renderer_for(replay, (640, 360), layout)
    for _ in rendered_frames(replay, renderer, Clip(0, 6000, fps=10)):
        pass
    *_, last = replay.worlds()
    first, second = last.team_scores
    expected = None if first == second else int(second > first)
    assert renderer.leader == expected
    assert any(prey.times_caught for prey in last.prey)
