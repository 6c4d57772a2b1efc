"""Pictures of matches with teams and prey show the scores of each."""

import pytest
from render.matches import played
from render.pictured import SIZES, assert_inside, assert_texts_apart, kinds

from catch_arena.config import ArenaConfig
from catch_arena.render import hud
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import Box, Label
from catch_arena.render.standings_animation import StandingsAnimation, standings_shapes
from catch_arena.render.team_scores import team_scores_shapes
from catch_arena.render.timing import Clip
from catch_arena.render.video import rendered_frames, renderer_for
from catch_arena.world import HunterState, PreyState, TargetState, World


def a_hunt() -> World:
    """Return a world with two hunters, a target, and prey that was caught and is out."""
    hunters = tuple(HunterState(f"hunter_{i}", x, 2.0, 0.5, 1.0, 0.0, i, team=i) for i, x in enumerate((1.0, 9.0)))
    targets = (TargetState("target_turtle_9", 9, 5.0, 5.0, 1.0, 480),)
    return World(500, 5, 11.088889122009277, hunters, targets, (), 9, (PreyState("prey_0", None, 3, 400),))


def test_prey_stands_below_the_hunters_the_seldomest_caught_first_and_is_said_to_be_out():
    standings = (*hud.standings_of(a_hunt()), hud.AgentScore(3, 0, hunted=True))
    assert [one.agent for one in hud.ranked(standings)] == [1, 0, 3, 2]
    animation = StandingsAnimation()
    animation.record(0.0, standings)
    info = MatchInfo.of(ArenaConfig(hunters=2, prey=2))
    area = hud.Rect(0, 0, 500, 250)
    shapes = standings_shapes(area, info, animation.lines(0.0), 1.0)
    rows = {label.text: label.y for label in kinds(shapes, Label)}
    assert rows["hunter_1"] < rows["hunter_0"] < rows["prey_1"] < rows["prey_0  (out)"]
    assert {"P0", "P1", "caught"} <= rows.keys()
    assert [box for box in kinds(shapes, Box) if box.color == info.colors[2]] == []  # no bar for prey
    assert_inside(shapes, area)


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
