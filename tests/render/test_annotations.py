"""Rulings are annotated in a picture with who won and why a request was refused."""

import dataclasses
import itertools
import math

import pytest
from render.pictured import a_world, annotated, kinds, shapes_of

from catch_arena.render.annotations import Annotation, Neighbour, spread_apart, visible_annotations
from catch_arena.render.shapes import Label
from catch_arena.verdicts import Ruling, Verdict

LONE = Annotation("catch", 400, 1, 9.0, 3.0)
LOST = Annotation("lost", 400, 1, 1.1, 2.1, "−59 mm")


def words(shapes) -> list[Label]:
    """Texts other than the hunters' numbers and names."""
    return [label for label in kinds(shapes, Label) if not label.text.isdecimal() and "hunter_" not in label.text]


def test_a_contest_tells_who_won_and_by_how_much_the_others_lost():
    after = a_world(
        Ruling(Verdict.GRANTED, 0, "target_turtle_7", 141_421, 0),
        Ruling(Verdict.LOST_CONTEST, 1, "target_turtle_7", 200_000, 0),
    )
    catch, lost = annotated(a_world(step=4), after)
    assert (catch.text, lost.text) == ("+1", "−59 mm")
    assert [(claim.seat, claim.distance_um) for claim in catch.contest.claims] == [(0, 141_421), (1, 200_000)]
    assert catch.neighbours == ()


def test_a_tie_and_a_contest_that_goes_by_lots_are_said_to_be_drawn():
    tie = a_world(
        Ruling(Verdict.GRANTED, 0, "target_turtle_7", 200_000, 0),
        Ruling(Verdict.LOST_CONTEST, 1, "target_turtle_7", 200_000, 0),
    )
    assert annotated(a_world(step=4), tie)[1].text == "by lot"
    first_come = a_world(
        Ruling(Verdict.GRANTED, 0, "target_turtle_7", 250_000, 0),
        Ruling(Verdict.LOST_CONTEST, 1, "target_turtle_7", 200_000, 0),
    )
    assert annotated(a_world(step=4), first_come, policy="first_come")[1].text == "by lot"


def test_who_was_near_without_asking_is_known_too_and_who_was_far_is_not():
    places = ((1.0, 2.0), (1.5, 2.1), (9.0, 9.0))
    after = a_world(Ruling(Verdict.GRANTED, 0, "target_turtle_7", 141_421, 0), places=places)
    (catch,) = annotated(a_world(step=4, places=places), after)
    assert catch.neighbours == (Neighbour(1, 400_000 - 141_421),)
    assert catch.contest is None


@pytest.mark.parametrize("verdict", sorted(set(Verdict) - {Verdict.GRANTED, Verdict.LOST_CONTEST}))
def test_every_refusal_is_shown_with_its_reason(verdict):
    (annotation,) = annotated(a_world(step=4), a_world(Ruling(verdict, 0, "target_turtle_7")))
    assert annotation.kind == "refused"
    assert annotation.text.upper().split() == verdict.name.split("_")
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


def test_of_repeated_refusals_only_the_latest_is_seen():
    refused = [Annotation("refused", time_ms, 0, 1.0, 1.0, "out of reach") for time_ms in (0, 100, 200)]
    assert visible_annotations(refused, 250.0) == refused[2:]


def test_the_numbers_of_a_dozen_bunched_hunters_can_all_be_read():
    places = [(30.0 + 7.0 * (seat % 4), 30.0 + 7.0 * (seat // 4)) for seat in range(12)]
    moved = spread_apart(places, 16.0)
    assert min(math.dist(a, b) for a, b in itertools.combinations(moved, 2)) > 12.0


def test_who_is_out_already_is_refused_in_silence_and_in_the_step_in_which_it_leaves_aloud():
    """R1.7: under fixed dropouts it goes on asking in every step."""
    refused = Ruling(Verdict.HUNTER_INACTIVE, 1, "target_turtle_7", None, None)
    before, after = a_world(step=4), a_world(refused)
    (refusal,) = annotated(before, after)
    assert (refusal.kind, refusal.seat, refusal.text) == ("refused", 1, "hunter inactive")
    out = before.hunters[1]._replace(withdrawn=True)
    assert annotated(dataclasses.replace(before, hunters=(before.hunters[0], out)), after) == ()
