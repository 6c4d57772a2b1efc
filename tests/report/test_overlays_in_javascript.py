"""The player draws captions, lenses, ghosts, podiums, names and numbers from the same shapes as videos."""

import itertools
import json
import math
import pathlib

import pytest
from render.matches import played
from report.javascript import deno

import catch_arena
from catch_arena.explanation import explain, what_if
from catch_arena.explanation.contests import contests_of
from catch_arena.player.bundle import bundle_text, css
from catch_arena.player.element import player_look
from catch_arena.render import annotations, captions, hud, lens, text
from catch_arena.render.cards import podium_shapes
from catch_arena.render.ghost import ghost_shapes, ghost_track, is_low
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import Box, Label, Path, Ring, Turtle
from catch_arena.render.viewport import Viewport
from catch_arena.verdicts import Verdict

DRAWER = pathlib.Path(__file__).with_name("draw_overlays.js")
SIDE = 610
MATCHES = {
    # more than four claimants, too many agents for names
    "crowd": {"side_m": 8.0, "reach_m": 0.6},
    "squads": {"side_m": 7.0},
    "herd": {"side_m": 5.0},
    "duel": {"side_m": 4.0, "initial_targets": 4, "policy": "first_come"},
}
AGES = {"crowd": 70.0, "squads": 1000.0, "herd": 2450.0, "duel": 160.0}
"""Age of the captions by match [ms]: growing, full, shrinking."""
NAMES = ("ann", "a name that does not fit", "ann", "b")


@pytest.fixture(scope="module")
def matches():
    """A replay of each scenario, in which hunters go for the nearest target."""
    replays = {}
    for scenario, changes in MATCHES.items():
        settings = {"time_limit_s": 12.0, "control": "target", **changes}
        config = catch_arena.scenario(scenario, **settings)
        names = [NAMES[agent % len(NAMES)] for agent in range(config.hunters + config.prey)]
        replays[scenario] = played(scenario, seed=7, names=names, **settings)
    return replays


@pytest.fixture(scope="module")
def answers(matches):
    """By scenario: answers to the first lost contests, and the instants at which they are drawn [ms]."""
    found = {}
    for scenario, replay in matches.items():
        lost = [
            contest
            for contest in explain(replay).contests
            if any(claim.verdict is Verdict.LOST_CONTEST for claim in contest.claims)
        ]
        given = [what_if(replay, contest) for contest in lost[:3]]
        times = [contest.judged_ms + shift for contest in lost[:3] for shift in (-650.0, -100.0, 0.0, 900.0)]
        found[scenario] = given, times
    assert any(answer.alternative is None for given, _ in found.values() for answer in given)
    return found


@pytest.fixture(scope="module", autouse=True)
def widths():
    """Each letter is half as wide as the text's size, as in the JavaScript under test."""

    def text_width(shown, size, _):
        return 0.5 * size * len(shown)

    with pytest.MonkeyPatch.context() as patch:
        for module in (text, lens, captions, annotations):
            patch.setattr(module, "text_width", text_width)
        patch.setattr(annotations, "truncated", text.truncated.__wrapped__)
        yield


def places(replay):
    """Return the poses at a match's end, by agent, as videos have them."""
    world = list(replay.worlds())[-1]
    hunters = {seat: (hunter.x, hunter.y, hunter.theta) for seat, hunter in enumerate(world.hunters)}
    info = MatchInfo.of_replay(replay)
    prey = {info.prey(target.prey): (target.x, target.y, target.theta) for target in world.targets if target.prey}
    return {**hunters, **prey}


@pytest.fixture(scope="module")
def drawn(matches, answers):
    """By scenario: the shapes that the player draws."""
    given = []
    for scenario, replay in matches.items():
        info, viewport = MatchInfo.of_replay(replay), Viewport(SIDE, SIDE, replay.config.side_m)
        agents = []
        for agent, pose in places(replay).items():
            hunted = agent >= replay.config.hunters
            x, y = viewport.to_pixels(*pose[:2])
            agents.append(
                {
                    "name": info.names[agent],
                    "number": info.number(agent),
                    "hunted": hunted,
                    "color": css(info.colors[agent]),
                    "reach": 0.0 if hunted else replay.config.reaches[agent] * viewport.scale,
                    "x": x,
                    "y": y,
                }
            )
        given.append(
            {
                "bundle": bundle_text(replay, answers[scenario][0]),
                "instants": answers[scenario][1],
                "age": AGES[scenario],
                "agents": agents,
                "length": viewport.hunter_length,
            }
        )
    found = deno(
        "run", "--no-remote", DRAWER, given=json.dumps({"look": player_look(), "side": SIDE, "matches": given})
    )
    return dict(zip(matches, json.loads(found), strict=True))


def row(shape):
    """Return a shape of render/ as the player's drawing calls have it."""
    match shape:
        case Box():
            return ["box", shape.left, shape.top, shape.width, shape.height, css(shape.color), shape.radius]
        case Ring():
            color = f"{css(shape.color)}{round(255 * shape.opacity):02x}"
            return ["ring", shape.x, shape.y, shape.radius, shape.width, color, shape.pieces]
        case Turtle():
            size, color, faded = shape.length, css(shape.color), float(shape.faded)
            return ["turtle", shape.x, shape.y, shape.theta, size, color, shape.contrast, faded]
        case Path():
            return ["path", *itertools.chain(*shape.points), shape.width, css(shape.color)]
        case Label():
            shown = text.truncated.__wrapped__(shape.text, shape.size, shape.weight, shape.max_width)
            outline = "" if shape.outline is None else css(shape.outline)
            color, weight = css(shape.color), shape.weight
            return ["label", shape.x, shape.y, shown, shape.size, color, weight, shape.align, outline]
    raise AssertionError(shape)


def parts_of(values):
    """Return the words, the numbers and the colours' channels of a drawing call; angles are within one turn."""
    words, numbers, channels = [], [], []
    for value in values:
        if isinstance(value, list):
            numbers += itertools.chain(*value)
        elif isinstance(value, str) and value.startswith("#"):
            given = bytes.fromhex(value[1:])
            channels += [*given, *[255] * (4 - len(given))]
        else:
            (words if isinstance(value, str) else numbers).append(value)
    if words == ["turtle"]:
        numbers[2:3] = [math.cos(numbers[2]), math.sin(numbers[2])]
    return words, numbers, channels


def assert_same(found, shapes):
    for one, other in zip(found, map(row, shapes), strict=True):
        words, numbers, channels = parts_of(other)
        drawn_words, drawn_numbers, drawn_channels = parts_of(one)
        assert drawn_words == words
        assert drawn_numbers == pytest.approx(numbers, abs=0.05), (one, other)  # bundles have rounded directions
        assert drawn_channels == pytest.approx(channels, abs=1.0), (one, other)


@pytest.mark.parametrize("scenario", MATCHES)
def test_captions_and_lenses_are_those_of_videos(matches, drawn, scenario):
    replay = matches[scenario]
    info, viewport = MatchInfo.of_replay(replay), Viewport(SIDE, SIDE, replay.config.side_m)
    commentary, expected = captions.Commentary(info), []
    for before, after in itertools.pairwise(replay.worlds()):
        last = commentary.caption
        found = annotations.annotations_of(before, after, contests_of(replay.config, after))
        commentary.record(before.time_ms, found, after.team_scores)
        if commentary.caption is not last:
            expected.append(commentary.caption)
    assert any(caption.lens for caption in expected)
    assert drawn[scenario]["times"] == [caption.time_ms for caption in expected]
    for one, caption in zip(drawn[scenario]["captions"], expected, strict=True):
        now = caption.time_ms + AGES[scenario]
        assert_same(one, captions.caption_shapes(viewport, info, caption, "plain", now))


@pytest.mark.parametrize("scenario", MATCHES)
def test_the_ghost_and_its_answer_are_those_of_videos(matches, answers, drawn, scenario):
    replay, (given, times) = matches[scenario], answers[scenario]
    info, viewport = MatchInfo.of_replay(replay), Viewport(SIDE, SIDE, replay.config.side_m)
    ghosts = 0
    for answer, instants in zip(given, drawn[scenario]["answers"], strict=True):
        track = ghost_track(answer)
        at_top = is_low(track, replay.config.side_m)
        words = captions.panel_shapes(viewport, info.colors[answer.seat], answer.sentence, at_top=at_top, whole=True)
        for time_ms, one in zip(times, instants, strict=True):
            ghost = ghost_shapes(viewport, info.colors[answer.seat], track, time_ms)
            ghosts += bool(ghost)
            assert_same(one, [*ghost, *words])
    assert ghosts


@pytest.mark.parametrize("scenario", MATCHES)
def test_the_podium_is_that_of_videos(matches, drawn, scenario):
    replay = matches[scenario]
    world = list(replay.worlds())[-1]
    prey = [score for score in hud.standings_of(world) if score.hunted]
    shapes = podium_shapes((SIDE, SIDE), MatchInfo.of_replay(replay), world.team_scores, prey)
    darkening, *podium = drawn[scenario]["podium"]
    assert darkening == ["box", 0, 0, SIDE, SIDE, "rgb(0 0 0 / 0.9)", 0]
    assert_same(podium, shapes)


@pytest.mark.parametrize("scenario", MATCHES)
def test_names_and_numbers_are_where_videos_have_them(matches, drawn, scenario):
    replay = matches[scenario]
    info, viewport = MatchInfo.of_replay(replay), Viewport(SIDE, SIDE, replay.config.side_m)
    shapes = annotations.annotation_shapes(viewport, info, places(replay), [], 0.0)
    assert_same(drawn[scenario]["agents"], shapes)
    names = [one for one in drawn[scenario]["agents"] if one[3] in NAMES or one[3].endswith("…")]
    assert bool(names) == (scenario != "crowd")
