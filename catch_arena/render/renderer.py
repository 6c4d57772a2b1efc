"""Pictures of a match: successive frames for videos, single ones for `env.render()`, and PNG."""

import base64
from collections.abc import Callable, Iterable
from typing import Final, get_args

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig, require_choice
from catch_arena.core.physics import TICK_MS
from catch_arena.errors import ConfigError
from catch_arena.explanation.contests import contests_of
from catch_arena.explanation.highlights import lead
from catch_arena.plain import plain_setting, whole_number
from catch_arena.render import cards, hud, scene
from catch_arena.render.annotations import Annotation, annotations_of, visible_annotations
from catch_arena.render.blurred_view import Belief, beliefs_of
from catch_arena.render.captions import Captions, Commentary, caption_shapes
from catch_arena.render.event_feed import FeedItem, feed_shapes, with_items
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.optional_imports import cv2
from catch_arena.render.raster import Canvas, Ground, Pixels
from catch_arena.render.shapes import Color, Shape
from catch_arena.render.standings_animation import StandingsAnimation, standings_shapes
from catch_arena.render.team_scores import team_scores_shapes
from catch_arena.render.timeline import Timeline
from catch_arena.render.viewport import Viewport
from catch_arena.replay.motion import Poses, StepMotion, poses_of, step_motion
from catch_arena.world import World

SMALLEST: Final = 320
LARGEST: Final = (3840, 2160)
NOTEBOOK_SIZE: Final = (800, 450)


def checked_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return the (width, height) of a frame; raise ConfigError for a size below SMALLEST or above LARGEST."""
    pair = plain_setting(size)
    good = isinstance(pair, tuple) and len(pair) == 2 and all(whole_number(part) is not None for part in pair)
    if not good or not (SMALLEST <= pair[0] <= LARGEST[0] and SMALLEST <= pair[1] <= LARGEST[1]):
        raise ConfigError(
            f"size must be two whole numbers from {SMALLEST} x {SMALLEST} to {LARGEST[0]} x {LARGEST[1]}, got {size!r}"
        )
    return pair[0], pair[1]


class MatchRenderer:
    """Frames of a match in one buffer: call `enter` for each step, then `draw` for the instants in it."""

    def __init__(
        self,
        info: MatchInfo,
        size: tuple[int, int],
        layout: hud.Layout,
        seed: int | None = None,
        captions: Captions = "plain",
    ) -> None:
        require_choice("layout", layout, get_args(hud.Layout))
        require_choice("captions", captions, get_args(Captions))
        self._caption_kind = captions
        self.info = info
        self.view_of: int | None = None
        """Seat whose view is shown (R7.5, R7.6) if hunters do not see everything as it is; None for no view."""
        self._seed = seed
        self._observations: dict[int, NDArray[np.float32]] = {}
        self._plan = hud.arrange(size, layout, len(info.names), len(info.contenders) if info.has_teams else 0)
        self._frame = Canvas.blank(*size, hud.PANEL)
        self.pixels = self._frame.pixels
        """Shared buffer of shape (height, width, 4), whose fourth byte is unused; the next `draw` overwrites it."""
        self.arena = self._plan.arena
        """Area of the arena in the picture."""
        self._arena = self._frame.part(self.arena)
        self.viewport = Viewport(*self.arena[2:], info.config.side_m)
        """Place of the arena's square in that area."""
        self._ground = Ground(self.viewport)
        self.reset()

    @property
    def leader(self) -> int | None:
        """Contender that alone has the most catches in the step that was entered last; None for a tie."""
        return lead(self._scores)[0]

    def reset(self, time_ms: float = 0.0) -> None:
        """Begin a new match, without trails or annotations."""
        self._ground.reset(time_ms)
        self._annotations: list[Annotation] = []
        self._commentary = Commentary(self.info)
        self._timeline = Timeline(self._plan.timeline, self.info, self._plan.unit)
        self._standings_animation = StandingsAnimation()
        self._feed: tuple[FeedItem, ...] = ()
        self._standings: tuple[hud.AgentScore, ...] = ()
        self._scores: tuple[int, ...] = ()
        self._prey_colors: dict[int, Color] = {}
        self._motion: StepMotion | None = None
        self._poses = Poses((), {})
        self._moved_ms = time_ms
        self._shown: dict[hud.Rect, object] = {}
        self._cursor = 0

    def observe(self, step: int, observations: NDArray[np.float32]) -> None:
        """Keep the hunters' observations (H, D) after `step` steps, from which beliefs are drawn if views have noise.

        Call this before the step that begins there is entered; observations before that step are then dropped.
        """
        if self.info.config.view_noise_m:
            self._observations[step] = observations.copy()

    def enter(self, motion: StepMotion) -> None:
        """Begin a step, with its rulings. Steps without a drawn instant must be entered too."""
        began_ms = motion.before.time_ms
        if self._motion is not None:
            self._extend_trails(began_ms)
            self._ground.fade(began_ms)
            # targets that appeared since begin a trail
            self._poses = Poses(self._poses.hunters, {**motion.poses[0].targets, **self._poses.targets})
        else:
            self._poses = motion.poses[0]
        self._motion = motion
        self._observations = {step: seen for step, seen in self._observations.items() if step >= motion.before.step}
        annotations = annotations_of(motion.before, motion.after, contests_of(self.info.config, motion.after))
        self._annotations = visible_annotations([*self._annotations, *annotations], began_ms)
        self._feed = with_items(self._feed, annotations)
        after = motion.after
        self._scores = after.team_scores
        self._commentary.record(began_ms, annotations, self._scores)
        self._prey_colors = {
            target.number: self.info.colors[self.info.prey(target.prey)]
            for target in after.targets
            if target.prey is not None
        }
        self._standings = hud.standings_of(after)
        self._standings_animation.record(began_ms, self._standings)
        catchers = [
            self.info.config.team_by_seat[annotation.seat] for annotation in annotations if annotation.kind == "catch"
        ]
        self._timeline.record(began_ms, catchers, self._scores)

    def draw(self, time_ms: float, poses: Poses) -> Pixels:
        """Draw one instant of the step that was entered last, with all turtles at `poses`, and return the buffer."""
        if self._motion is None:
            raise ValueError("a step must be entered before one of its instants is drawn")
        self._extend_trails(time_ms, poses)
        self._ground.fade(time_ms)
        self._annotations = visible_annotations(self._annotations, time_ms)
        world = self._motion.after
        self._arena.pixels[:] = self._ground.pixels
        beliefs = self._beliefs(self._motion.before.step)
        self._arena.draw(
            scene.arena_shapes(
                self.viewport, self.info, world, poses, self._annotations, time_ms, self.view_of, beliefs
            )
        )
        caption = self._commentary.caption
        if caption is not None:
            self._arena.draw(caption_shapes(self.viewport, self.info, caption, self._caption_kind, time_ms))
        self._draw_around(time_ms, min(time_ms, world.time_ms))
        return self.pixels

    def draw_title(self, part: float) -> Pixels:
        """Draw the title over the dimmed arena as drawn last; `part` in [0, 1] is its strength."""
        return self._draw_card(cards.title_shapes((self.arena.width, self.arena.height), self.info), part)

    def draw_podium(self, part: float = 1.0) -> Pixels:
        """Draw the podium over the dimmed arena as drawn last; `part` in [0, 1] is its strength."""
        prey = [score for score in self._standings if score.hunted]
        area = (self.arena.width, self.arena.height)
        return self._draw_card(cards.podium_shapes(area, self.info, self._scores, prey), part)

    def _draw_card(self, drawn: Iterable[Shape], part: float) -> Pixels:
        """Dim the arena by `part`, and draw a card over it once it is dark enough."""
        pixels = self._arena.pixels
        cv2.convertScaleAbs(pixels, pixels, 1.0 - part * (1.0 - cards.DIMMED))
        if part > 0.5:
            self._arena.draw(drawn)
        return self.pixels

    def draw_over(self, drawn: Iterable[Shape]) -> None:
        """Draw shapes over the arena, in pixels from its corner; the next `draw` removes them."""
        self._arena.draw(drawn)

    def _beliefs(self, step: int) -> list[Belief]:
        """R7.6: return the beliefs of the hunter whose view is shown; empty without view or observations."""
        if self.view_of is None or step not in self._observations:
            return []
        return beliefs_of(self.info.config, self.view_of, self._observations[step][self.view_of])

    def _extend_trails(self, until_ms: float, *last: Poses) -> None:
        """Lead the trails through the ticks since the last instant, if it is more than two ticks ago, and to `last`.

        The trail of a prey is like a hunter's.
        """
        way = [self._poses, *last]
        if self._motion is not None and until_ms - self._moved_ms > 2 * TICK_MS:
            way[1:1] = self._motion.ticks_between(self._moved_ms, until_ms)
        self._moved_ms, self._poses = until_ms, way[-1]
        for number in self._poses.targets:
            own = [poses.targets[number] for poses in way if number in poses.targets]
            self._ground.draw_trail(own, self._prey_colors.get(number))
        for seat in range(len(self._poses.hunters)):
            self._ground.draw_trail([poses.hunters[seat] for poses in way], self.info.colors[seat])

    def _draw_around(self, time_ms: float, played_ms: float) -> None:
        """Draw the parts around the arena; the clock stands still after the end."""
        plan, info, unit = self._plan, self.info, self._plan.unit
        clock = hud.clock(played_ms)
        if not plan.standings.width:
            left, right = hud.split_strip(plan.header, info)
            state = self._scores, self._standings
            self._update(left, state, lambda: hud.strip_shapes(left, info, *state))
            self._update(right, clock, lambda: hud.strip_clock_shapes(right, clock))
            return
        self._update(plan.header, clock, lambda: hud.header_shapes(plan.header, info, self._seed, clock, unit))
        self._update(plan.teams, self._scores, lambda: team_scores_shapes(plan.teams, info, self._scores, unit))
        lines, view_of = self._standings_animation.lines(time_ms), self.view_of
        self._update(
            plan.standings, (lines, view_of), lambda: standings_shapes(plan.standings, info, lines, unit, view_of)
        )
        self._update(plan.feed, self._feed, lambda: feed_shapes(plan.feed, info, self._feed, unit))
        timeline, card = self._timeline, self._frame.part(plan.timeline)
        redrawn = self._update(plan.timeline, timeline.catches, timeline.past_shapes)
        if redrawn:
            self._past = card.pixels.copy()
        cursor = round(timeline.x(time_ms))
        if redrawn or cursor != self._cursor:
            self._cursor = cursor
            card.pixels[:] = self._past
            self._frame.draw(timeline.present_shapes(time_ms))

    def _update(self, area: hud.Rect, state: object, shapes: Callable[[], list[Shape]]) -> bool:
        """Draw a part again if its state has changed; return whether it was drawn."""
        if not area.width or (area in self._shown and self._shown[area] == state):
            return False
        self._shown[area] = state
        self._frame.clear(area, hud.PANEL)
        self._frame.draw(shapes())
        return True


class ArenaPainter:
    """Painter of one arena's picture at every step that is shown, for `env.render()`.

    Trails and catches come from the worlds that were painted before. They begin again at a world of step 0, and at one
    of an earlier step.
    """

    def __init__(self, config: ArenaConfig, size: tuple[int, int] = (500, 500), layout: hud.Layout = "arena") -> None:
        self._renderer = MatchRenderer(MatchInfo.of(config), size, layout)
        self._last: World | None = None

    def paint(self, world: World) -> Pixels:
        """Return a new (height, width, 3) uint8 frame of the world."""
        self.enter(world)
        return np.asarray(cv2.cvtColor(self.draw(1.0), cv2.COLOR_RGBA2RGB), dtype=np.uint8)

    def enter(self, world: World) -> float:
        """Set the world that is drawn; return the time since the last one [ms], 0 if it does not follow that."""
        renderer, last = self._renderer, self._last
        self._last = world
        if last is None or world.step == 0 or world.step < last.step:
            renderer.reset(float(world.time_ms))
            self._motion = step_motion(world, world)
            renderer.enter(self._motion)
        elif world.step == last.step:
            self._motion = step_motion(world, world)
        else:
            if world.step == last.step + 1:
                self._motion = step_motion(last, world)
            else:  # steps were left out: their rulings are not known, and the way is a straight line
                self._motion = StepMotion(last, world, (poses_of(world),))
            renderer.enter(self._motion)
        return float(world.time_ms - self._motion.before.time_ms)

    def draw(self, part: float) -> Pixels:
        """Draw a part in (0, 1] of the way to the world; return a (height, width, 4) buffer that is used again."""
        motion = self._motion
        if part == 1.0:
            return self._renderer.draw(float(motion.after.time_ms), motion.poses[-1])
        time_ms = motion.before.time_ms + part * (motion.after.time_ms - motion.before.time_ms)
        return self._renderer.draw(time_ms, motion.at(time_ms))


def png_html(config: ArenaConfig, world: World) -> str:
    """Return an HTML image of a world with its standings, which includes the picture's data."""
    pixels = ArenaPainter(config, size=NOTEBOOK_SIZE, layout="broadcast").paint(world)
    content = cv2.imencode(".png", cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR))[1].tobytes()
    caption = f"step {world.step}, {world.time_ms / 1000:.1f} s"
    return f'<img alt="Catch Arena, {caption}" src="data:image/png;base64,{base64.b64encode(content).decode()}">'
