"""R7.6: the view of a hunter shows where the hunter believes others to be."""

import math

import pytest
from render.pictured import a_world, kinds, shapes_of

from catch_arena.layout import columns
from catch_arena.render.blurred_view import Belief, beliefs_of
from catch_arena.render.shapes import Ring
from catch_arena.render.viewport import Viewport

HARDLY = 1e-5
"""Noise that only a number tells from none [m]."""


@pytest.mark.parametrize(
    ("scenario", "settings"),
    [
        ("standard", {}),
        ("fog", {"view_angle_deg": 200.0}),
        ("evasive", {"observed_targets": 3, "observed_hunters": 2}),
        ("squads", {}),
        ("tag", {"view_radius_m": 6.0}),
        ("dropout", {"dropout_rate": 0.5}),
    ],
)
def test_each_thing_in_view_and_nothing_else_is_believed_to_be_somewhere(play, scenario, settings):
    """With hardly any noise it is believed to be where it is."""
    match = play(scenario, view_noise_m=HARDLY, time_limit_s=6.0, **settings)
    flags = [place for place, column in enumerate(columns(match.config)) if column.name.endswith(".present")]
    believed = 0
    for engine in match.checked_engines():
        world = engine.world()
        for seat, hunter in enumerate(world.hunters):
            if hunter.withdrawn:
                continue
            observation = engine.observations[0, seat]
            targets = [(target.x, target.y) for target in world.targets]
            rivals = [(rival.x, rival.y) for rival in world.hunters if rival is not hunter and not rival.withdrawn]
            beliefs = beliefs_of(match.config, seat, observation)
            assert len(beliefs) == observation[flags].sum()
            for one in beliefs:
                places = targets if one.is_target else rivals
                nearest = min(places, key=lambda place: math.dist(place, one[:2]))
                assert math.dist(nearest, one[:2]) < 10 * HARDLY
                places.remove(nearest)  # no other belief is about the same
            believed += len(beliefs)
    assert believed > 50


def test_a_ring_is_where_it_is_believed_to_be():
    world = a_world()
    to_pixels = Viewport(720, 720, world.side_m).to_pixels
    beliefs = [Belief(4.0, 6.0, is_target=True), Belief(2.0, 2.5, is_target=False)]
    plain, seen = (shapes_of(world, view_of=1, beliefs=some) for some in ((), beliefs))
    added = [shape for shape in seen if shape not in plain]

    assert added == kinds(added, Ring)
    assert [(ring.x, ring.y) for ring in added] == [to_pixels(*one[:2]) for one in beliefs]
    assert added[0].radius < added[1].radius  # targets are smaller than hunters
