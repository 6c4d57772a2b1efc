"""What was ruled, as it is seen: without a pixel."""

import dataclasses
import itertools
import math

import pytest
from render.pictured import a_world, kinds, shapes_of

from catch_arena.render import annotations
from catch_arena.render.annotations import Annotation, Rival, annotations_of, spread_apart, visible_annotations
from catch_arena.render.shapes import Label, Stroke
from catch_arena.render.viewport import Viewport
from catch_arena.verdicts import Ruling, Verdict

LONE = Annotation("catch", 400, 1, 9.0, 3.0)
LOST = Annotation("lost", 400, 1, 1.1, 2.1, "−59 mm")


def words(shapes) -> list[Label]:
    return [label for label in kinds(shapes, Label) if not label.text.isdecimal()]


def test_rulings_are_shown_where_the_target_was_from_the_boundary_at_which_they_were_judged():
    before = a_world(step=4)
    after = a_world(
        Ruling(Verdict.GRANTED, 0, "target_turtle_7", 141421, 0),
        Ruling(Verdict.LOST_CONTEST, 1, "target_turtle_7", 200000, 0),
    )
    catch, lost = annotations_of(before, after)
    assert (catch.kind, catch.seat, catch.x, catch.y, catch.time_ms) == ("catch", 0, 1.1, 2.1, 400)
    assert (lost.kind, lost.seat, lost.x, lost.y, lost.time_ms) == ("lost", 1, 1.1, 2.1, 400)


def test_a_contest_tells_who_won_and_by_how_much_the_others_lost():
    after = a_world(
        Ruling(Verdict.GRANTED, 0, "target_turtle_7", 141_421, 0),
        Ruling(Verdict.LOST_CONTEST, 1, "target_turtle_7", 200_000, 0),
    )
    catch, lost = annotations_of(a_world(step=4), after)
    assert (catch.text, lost.text) == ("+1", "−59 mm")
    assert catch.rivals == (Rival(1, 200_000, requested=True),)
    assert catch.distance_um == 141_421


def test_a_tie_and_a_contest_that_goes_by_lots_are_said_to_be_drawn():
    tie = a_world(
        Ruling(Verdict.GRANTED, 0, "target_turtle_7", 200_000, 0),
        Ruling(Verdict.LOST_CONTEST, 1, "target_turtle_7", 200_000, 0),
    )
    assert annotations_of(a_world(step=4), tie)[1].text == "by lot"
    first_come = a_world(
        Ruling(Verdict.GRANTED, 0, "target_turtle_7", 250_000, 0),
        Ruling(Verdict.LOST_CONTEST, 1, "target_turtle_7", 200_000, 0),
    )
    assert annotations_of(a_world(step=4), first_come, by_lot=True)[1].text == "by lot"


def test_who_was_near_without_asking_is_known_too_and_who_was_far_is_not():
    places = ((1.0, 2.0), (1.5, 2.1), (9.0, 9.0))
    after = a_world(Ruling(Verdict.GRANTED, 0, "target_turtle_7", 141_421, 0), places=places)
    (catch,) = annotations_of(a_world(step=4, places=places), after)
    assert catch.rivals == (Rival(1, 400_000, requested=False),)


def test_a_grant_of_what_never_was_is_shown_at_the_hunter():
    """The capstone profile grants any name (R9.1)."""
    (annotation,) = annotations_of(a_world(step=4), a_world(Ruling(Verdict.GRANTED, 1, "no_such_turtle")))
    assert (annotation.x, annotation.y, annotation.rivals) == (9.0, 3.0, ())


@pytest.mark.parametrize("verdict", sorted(set(Verdict) - {Verdict.GRANTED, Verdict.LOST_CONTEST}))
def test_every_refusal_is_shown_with_its_reason(verdict):
    (annotation,) = annotations_of(a_world(step=4), a_world(Ruling(verdict, 0, "target_turtle_7")))
    assert annotation.kind == "refused"
    assert annotation.text == annotations.SHORT_REASONS[verdict]
    assert annotation.text in [label.text for label in words(shapes_of(a_world(), [annotation]))]


def test_where_many_are_refused_or_turtles_are_small_a_refusal_is_an_exclamation_mark():
    refused = [Annotation("refused", 400, seat, 1.0, 1.0, "out of reach") for seat in range(7)]
    world = a_world(places=[(1.0 + seat, 5.0) for seat in range(7)])
    assert {label.text for label in words(shapes_of(world, refused))} == {"!"}
    assert {label.text for label in words(shapes_of(world, refused[:2]))} == {"out of reach"}
    assert {label.text for label in words(shapes_of(world, refused[:2], size=(320, 300)))} == {"!"}


@pytest.mark.parametrize("annotation", [LONE, LOST], ids=["catch", "lost"])
def test_an_annotation_puts_its_text_at_the_hunter_and_passes(annotation):
    assert annotation.text in [label.text for label in words(shapes_of(a_world(), [annotation]))]
    assert visible_annotations([annotation], 400 + annotation.visible_ms - 1) == [annotation]
    assert visible_annotations([annotation], 400 + annotation.visible_ms) == []


def test_a_lost_contest_is_a_line_from_the_loser_to_the_target():
    viewport = Viewport(720, 720, 11.088889122009277)
    (line,) = kinds(shapes_of(a_world(), [LOST]), Stroke)
    assert (line.x0, line.y0, line.x1, line.y1) == (*viewport.to_pixels(9.0, 3.0), *viewport.to_pixels(1.1, 2.1))


def test_of_repeated_refusals_only_the_latest_is_seen():
    refused = [Annotation("refused", time_ms, 0, 1.0, 1.0, "out of reach") for time_ms in (0, 100, 200)]
    assert visible_annotations(refused, 250.0) == refused[2:]


@pytest.mark.parametrize("size", [(320, 298), (720, 720)])
@pytest.mark.parametrize(("kind", "word"), [("catch", "+1"), ("lost", "−0.9 mm"), ("refused", "already caught")])
def test_words_stay_inside_the_picture_at_every_corner(size, kind, word):
    for x, y in itertools.product((0.0, 11.0888), repeat=2):
        world = a_world(places=((x, y),))
        for time_ms in (400.0, 800.0, 1000.0):
            for label in kinds(shapes_of(world, [Annotation(kind, 400, 0, x, y, word)], time_ms, size), Label):
                assert label.size * 0.5 <= label.y <= size[1] - label.size * 0.5
                assert 0.3 * label.size * len(label.text) <= label.x
                assert label.x <= size[0] - 0.3 * label.size * len(label.text)


def test_words_and_numbers_of_hunters_that_bunch_do_not_cover_each_other():
    """Three that meet at one target: one catches, two lose; all stand within a few centimetres."""
    places = ((5.0, 5.0), (5.05, 5.02), (4.96, 5.04))
    shown = [Annotation("catch", 400, 0, 5.0, 5.0), Annotation("lost", 400, 1, 5.0, 5.0, "−12 mm")]
    shown.append(Annotation("lost", 400, 2, 5.0, 5.0, "−40 mm"))
    for time_ms in range(400, 1300, 50):
        labels = kinds(shapes_of(a_world(places=places), visible_annotations(shown, time_ms), float(time_ms)), Label)
        for one, other in itertools.combinations(labels, 2):
            beside = abs(one.x - other.x) - 0.25 * (len(one.text) * one.size + len(other.text) * other.size)
            above = abs(one.y - other.y) - 0.4 * (one.size + other.size)
            assert beside >= 0 or above >= 0, (time_ms, one, other)


def test_numbers_that_are_apart_stay_where_they_are():
    places = [(10.0, 10.0), (50.0, 10.0), (10.0, 50.0)]
    for moved, place in zip(spread_apart(places, 20.0), places, strict=True):
        assert moved == pytest.approx(place, abs=0.01)


def test_numbers_in_one_place_part_and_stay_near_it():
    moved = spread_apart([(30.0, 30.0)] * 5, 12.0)
    assert min(math.dist(a, b) for a, b in itertools.combinations(moved, 2)) > 11.0
    assert max(math.dist(place, (30.0, 30.0)) for place in moved) <= 24.1


def test_the_numbers_of_a_dozen_bunched_hunters_can_all_be_read():
    places = [(30.0 + 7.0 * (seat % 4), 30.0 + 7.0 * (seat // 4)) for seat in range(12)]
    moved = spread_apart(places, 16.0)
    assert min(math.dist(a, b) for a, b in itertools.combinations(moved, 2)) > 12.0


def test_numbers_do_not_jump_when_hunters_pass_each_other():
    """They swing round each other: quickly, but without a gap, as steps of a hundredth of a pixel show."""
    last = None
    for step in range(2500, 3500):
        now = spread_apart([(step / 100.0, 30.0), (60.0 - step / 100.0, 31.0), (30.0, 33.0)], 12.0)
        if last is not None:
            assert max(math.dist(a, b) for a, b in zip(last, now, strict=True)) < 0.25
        last = now


def test_who_is_out_already_is_refused_in_silence_and_in_the_step_in_which_it_leaves_aloud():
    """R1.7: under fixed dropouts it goes on asking in every step."""
    refused = Ruling(Verdict.HUNTER_INACTIVE, 1, "target_turtle_7", None, None)
    before, after = a_world(step=4), a_world(refused)
    (told,) = annotations_of(before, after)
    assert (told.kind, told.seat, told.text) == ("refused", 1, "withdrawn")
    out = dataclasses.replace(before.hunters[1], withdrawn=True)
    assert annotations_of(dataclasses.replace(before, hunters=(before.hunters[0], out)), after) == ()
