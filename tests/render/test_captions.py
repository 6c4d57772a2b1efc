"""A contest is shown by a lens and a caption: who won, over whom, and by how many millimetres."""

import math

import pytest
from render.pictured import SIZES, a_world, an_info, annotated, assert_inside, kinds

from catch_arena.config import ArenaConfig
from catch_arena.explanation.formatting import millimetres
from catch_arena.render import hud
from catch_arena.render.captions import Commentary, caption_shapes
from catch_arena.render.event_feed import with_items
from catch_arena.render.lens import LENS_MS, spread_directions
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import Label, Turtle
from catch_arena.render.viewport import Viewport
from catch_arena.verdicts import Ruling, Verdict

INFO = MatchInfo.of(ArenaConfig(hunters=2), ("ann", "bob"))


def contest(won_um: int, lost_um: int, **settings) -> tuple:
    """Annotations of a contest that hunter 0 wins."""
    after = a_world(
        Ruling(Verdict.GRANTED, 0, "target_turtle_7", won_um, 0),
        Ruling(Verdict.LOST_CONTEST, 1, "target_turtle_7", lost_um, 0),
    )
    return annotated(a_world(step=4), after, **settings)


def caption_after(annotations, info=INFO, scores=(1, 0)):
    commentary = Commentary(info)
    commentary.record(400, annotations, scores)
    return commentary.caption


@pytest.mark.parametrize(
    ("distances", "settings", "text", "clause"),
    [
        ((141_000, 152_000), {}, "ann steals it from bob by 11 mm", "R5.4"),
        ((141_000, 141_001), {}, "ann steals it from bob by 0.001 mm", "R5.4"),
        ((100_000, 250_000), {}, "ann beats bob to it by 150 mm", "R5.4"),
        ((200_000, 200_000), {}, "ann and bob are equally near: ann wins the draw", "R5.5"),
        ((250_000, 200_000), {"policy": "first_come"}, "ann is first in the queue, before bob", "R5.9"),
    ],
)
def test_the_caption_of_a_contest_names_the_winner_and_the_reason(distances, settings, text, clause):
    info = MatchInfo.of(ArenaConfig(hunters=2, **settings), ("ann", "bob"))
    caption = caption_after(contest(*distances, **settings), info)
    assert (caption.text, caption.clause) == (text, clause)


def labels(caption, kind, info=INFO, size=(720, 720), time_ms=900.0) -> list[str]:
    shapes = caption_shapes(Viewport(*size, 11.0), info, caption, kind, time_ms)
    return [label.text for label in kinds(shapes, Label)]


def test_captions_are_plain_or_have_their_clause_or_are_left_out():
    caption = caption_after(contest(141_000, 152_000))
    assert labels(caption, "plain")[-1] == "ann steals it from bob by 11 mm"
    assert labels(caption, "clauses")[-1] == "ann steals it from bob by 11 mm (R5.4)"
    assert labels(caption, "none")[-1] == "11 mm nearer"  # the lens stays
    assert labels(caption, "plain", time_ms=400.0 + LENS_MS) == []
    assert labels(caption, "plain", size=(300, 300)) == []


def test_the_lens_shows_both_hunters_apart_with_their_distances():
    caption = caption_after(contest(141_000, 152_000))
    shapes = caption_shapes(Viewport(720, 720, 11.0), INFO, caption, "none", 900.0)
    assert {"ann", "bob", "141 mm", "152 mm", "11 mm nearer"} <= {label.text for label in kinds(shapes, Label)}
    *hunters, target = kinds(shapes, Turtle)
    places = [(turtle.x, turtle.y) for turtle in (*hunters, target)]
    assert math.dist(places[0], places[1]) > 0.8 * hunters[0].length
    far, near = (math.dist(place, places[-1]) for place in places[:-1])
    assert near / far == pytest.approx(141 / 152)


def test_hunters_on_one_side_of_the_target_are_turned_apart():
    turned = spread_directions([0.3, 0.3, 0.31, 3.0])
    for index, one in enumerate(turned):
        for other in turned[:index]:
            assert abs(math.remainder(one - other, 2 * math.pi)) > math.radians(60)
    assert spread_directions([0.0, 2.0]) == pytest.approx([0.0, 2.0], abs=0.002)


def test_there_is_no_lens_among_team_mates_or_without_a_contest():
    after = a_world(Ruling(Verdict.GRANTED, 0, "target_turtle_7", 141_421, 0))
    (catch,) = annotated(a_world(step=4), after)
    assert catch.lens is None
    assert caption_after([catch]) is None


def test_a_contest_of_teams_is_won_from_the_nearest_hunter_of_another_team():
    """R11.3: a team-mate that was nearer lost nothing to its own team."""
    places, teams = ((1.0, 2.0), (1.2, 2.0), (1.0, 2.4)), ((0, 1), (2,))
    after = a_world(
        Ruling(Verdict.GRANTED, 0, "target_turtle_7", 141_000, 0),
        Ruling(Verdict.LOST_CONTEST, 1, "target_turtle_7", 142_000, 0),
        Ruling(Verdict.LOST_CONTEST, 2, "target_turtle_7", 152_000, 0),
        places=places,
    )
    info = MatchInfo.of(ArenaConfig(hunters=3, teams=teams), ("ann", "amy", "bob"))
    annotations = annotated(a_world(step=4, places=places), after, teams=teams)
    caption = caption_after(annotations, info)
    assert caption.text == "ann steals it from bob by 11 mm"
    assert {"ann", "bob", "11 mm nearer"} <= set(labels(caption, "plain", info))
    assert with_items((), annotations)[0].parts == (0, "beat", 2, "by 11 mm")


def test_a_new_leader_is_news_and_the_first_one_is_not():
    commentary = Commentary(INFO)
    for scores in ((1, 0), (1, 1)):
        commentary.record(400, (), scores)
        assert commentary.caption is None
    commentary.record(600, (), (1, 2))
    assert (commentary.caption.text, commentary.caption.agent) == ("bob takes the lead", 1)


@pytest.mark.parametrize("name", ["", "x" * 80, "агент", "وكيل", "漢字の名前"])
@pytest.mark.parametrize("size", SIZES)
def test_names_of_any_kind_stay_inside(name, size):
    info = MatchInfo.of(ArenaConfig(hunters=2), (name, name + "y"))
    area = hud.Rect(0, 0, *size)
    for kind in ("plain", "clauses"):
        shapes = caption_shapes(Viewport(*size, 11.0), info, caption_after(contest(9_000, 152_000), info), kind, 900.0)
        assert_inside(kinds(shapes, Label), area)


@pytest.mark.parametrize(
    ("length_um", "text"), [(1, "0.001 mm"), (170, "0.17 mm"), (1_240, "1.2 mm"), (9_960, "10 mm"), (232_175, "232 mm")]
)
def test_lengths_are_millimetres(length_um, text):
    assert millimetres(length_um) == text


def test_agents_of_a_tournament_keep_their_colours():
    config = ArenaConfig(hunters=4)
    one = MatchInfo.of(config, "abcd", colors=(5, 0, 2, 1))
    other = MatchInfo.of(config, "baec", colors=(0, 5, 7, 2))
    assert (one.colors[0], one.colors[1], one.colors[2]) == (other.colors[1], other.colors[0], other.colors[3])
    twice = MatchInfo.of(config, "aabc", colors=(5, 5, 0, 1))
    assert len({twice.colors[seat] for seat in range(4)}) == 4
    assert an_info(4).colors[1] != an_info(4).colors[0]
