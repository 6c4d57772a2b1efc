"""R7.6 in pictures: where the hunter whose view is shown believes what it sees to be."""

import math

import numpy as np
import pytest
from render.pictured import a_world, beliefs_of, kinds, note_beliefs, shapes_of
from render.videos import SMALL

from catch_arena.layout import columns
from catch_arena.render.blurred_view import Belief, BlurredView
from catch_arena.render.shapes import Ring, Stroke
from catch_arena.render.timing import Clip
from catch_arena.render.video import frames_of, observed_worlds, renderer_for
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


def test_beliefs_are_the_observations_own_numbers(play):
    """Turned into the world's frame, and back again."""
    match = play("evasive", view_noise_m=0.5, max_cycles=3)
    view = BlurredView(match.config)
    names = [column.name for column in columns(match.config)]
    for engine in match.checked_engines():
        world, observation = engine.world(), engine.observations[0, 2]
        me = world.hunters[2]
        beliefs = view.beliefs(world, 2, observation)
        ways = np.array([complex(one.x - me.x, one.y - me.y) for one in beliefs]) * np.exp(-1j * me.theta)
        told = dict(zip(names, observation.tolist(), strict=True))
        seen = [name.removesuffix(".present") for name in names if name.endswith(".present") and told[name]]
        np.testing.assert_allclose(ways.real, [told[f"{name}.forward"] for name in seen], atol=1e-5)
        np.testing.assert_allclose(ways.imag, [told[f"{name}.left"] for name in seen], atol=1e-5)


def test_a_ring_is_where_it_is_believed_to_be_and_a_line_leads_to_where_it_is():
    """Of a target that has just been caught, and of one that is believed to be where it is, there is no line."""
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


@pytest.mark.parametrize("times", [Clip(300, 1200, 30).times_ms, [0.0, 450.0, 1900.0, 2000.0]])
def test_each_picture_has_what_was_observed_when_its_step_began(play, monkeypatch, times):
    """The hunter acts on that, until the next step begins."""
    match = play("evasive", view_noise_m=0.5, time_limit_s=2.0)
    steps = beliefs_of(match, 1)
    drawn = note_beliefs(monkeypatch)
    renderer = renderer_for(match, SMALL["size"], "arena")
    renderer.view_of = 1
    list(frames_of(observed_worlds(match, renderer), renderer, times))
    assert len(drawn) == len(times)
    for time_ms, beliefs in drawn:
        step = min(int(time_ms // match.config.control_period_ms), match.steps - 1)
        assert beliefs == steps[step]
        assert beliefs
