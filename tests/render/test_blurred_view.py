"""R7.6: the view of a hunter shows where the hunter believes others to be."""

import math

import pytest
from render.pictured import a_world, kinds, shapes_of

from catch_arena.layout import columns
from catch_arena.render.blurred_view import Belief, BlurredView
from catch_arena.render.shapes import Ring, Stroke
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
    """With hardly any noise it is believed to be where it is, so none is taken for another."""
    match = play(scenario, view_noise_m=HARDLY, time_limit_s=6.0, **settings)
    view = BlurredView(match.config)
    flags = [place for place, column in enumerate(columns(match.config)) if column.name.endswith(".present")]
    believed = 0
    for engine in match.checked_engines():
        world = engine.world()
        places = {target.number: (target.x, target.y) for target in world.targets}
        for seat, hunter in enumerate(world.hunters):
            if hunter.withdrawn:
                continue
            observation = engine.observations[0, seat]
            beliefs = view.beliefs(world, seat, observation)
            assert len(beliefs) == observation[flags].sum()
            for one in beliefs:
                other = None if one.rival is None else world.hunters[one.rival]
                true = places[one.target] if other is None else (other.x, other.y)
                assert math.dist((one.x, one.y), true) < 10 * HARDLY
            believed += len(beliefs)
    assert believed > 50


def test_a_ring_is_where_it_is_believed_to_be_and_a_line_leads_to_where_it_is():
    """There is no line for a target that was just caught, or that is where it is believed to be."""
    world = a_world()
    to_pixels = Viewport(720, 720, world.side_m).to_pixels
    beliefs = [
        Belief(4.0, 6.0, target=9),
        Belief(2.0, 2.5, rival=0),
        Belief(1.1, 2.1, target=7),
        Belief(3.0, 3.0, target=8),
    ]
    plain, seen = (shapes_of(world, view_of=1, beliefs=some) for some in ((), beliefs))
    added = [shape for shape in seen if shape not in plain]

    assert [(ring.x, ring.y) for ring in kinds(added, Ring)] == [to_pixels(*one[:2]) for one in beliefs[:3]]
    lines = kinds(added, Stroke)
    assert [(line.x1, line.y1) for line in lines] == [to_pixels(5.0, 5.0), to_pixels(1.0, 2.0)]
    for line, ring in zip(lines, kinds(added, Ring), strict=False):
        assert math.hypot(line.x0 - ring.x, line.y0 - ring.y) == pytest.approx(ring.radius)
