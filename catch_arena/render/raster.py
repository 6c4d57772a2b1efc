"""Shapes to pixels: pygame and cv2 draw into one shared RGBX buffer; no display is opened."""

from collections.abc import Iterable, Sequence
from typing import Any, Final, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError, suggest
from catch_arena.render import hud, scene
from catch_arena.render.motion import Leg, leg
from catch_arena.render.sdl import pygame
from catch_arena.render.sprites import SpriteCache
from catch_arena.world import World

Pixels = NDArray[np.uint8]

SMALLEST: Final = 320
LARGEST: Final = (3840, 2160)

_SHIFT: Final = 4
"""cv2 takes places in sixteenths of a pixel."""
_WIDEST_RING: Final = 600.0
FADE_MS: Final = 200
"""A trail fades by one step in so much of the match's time."""
TRACE_FADE_MS: Final = 2000


def checked_size(size: tuple[int, int]) -> tuple[int, int]:
    """The (width, height) [pixels] of a frame, if it can be. Raises: ConfigError."""
    good = isinstance(size, Sequence) and len(size) == 2
    good = good and all(isinstance(part, int) and not isinstance(part, bool) for part in size)
    if not good or not (SMALLEST <= size[0] <= LARGEST[0] and SMALLEST <= size[1] <= LARGEST[1]):
        raise ConfigError(
            f"size must be two whole numbers from {SMALLEST} x {SMALLEST} to {LARGEST[0]} x {LARGEST[1]}, got {size!r}"
        )
    return size[0], size[1]


class Canvas:
    """A buffer, or a part of one, that shapes are drawn on; what lies outside is cut off."""

    def __init__(self, buffer: Pixels, surface: "pygame.Surface", sprites: SpriteCache) -> None:
        self.pixels = buffer
        """(height, width, 4): red, green, blue and a byte that means nothing."""
        self._surface = surface
        self._sprites = sprites

    @classmethod
    def blank(cls, width: int, height: int, color: scene.Color, sprites: SpriteCache) -> "Canvas":
        """A new buffer of one colour."""
        buffer = np.empty((height, width, 4), dtype=np.uint8)
        buffer[:] = (*color, 255)
        return cls(buffer, pygame.image.frombuffer(buffer.data, (width, height), "RGBX"), sprites)

    def part(self, area: hud.Rect) -> "Canvas":
        """The same pixels, seen through a rectangle."""
        left, top, width, height = area
        return Canvas(
            self.pixels[top : top + height, left : left + width], self._surface.subsurface(area), self._sprites
        )

    def draw(self, shapes: Iterable[scene.Shape]) -> None:
        """Draw shapes, the first one lowest."""
        for shape in shapes:
            match shape:
                case scene.Turtle():
                    self._blit(*self._sprites.turtle(shape))
                case scene.Label():
                    if shape.text:
                        self._blit(*self._sprites.label(shape))
                case scene.Ring():
                    self._ring(shape)
                case scene.Stroke():
                    self._stroke(shape)
                case scene.Polygon():
                    points = np.array(shape.points, dtype=np.float64)
                    self._fill(points, shape.color)
                case scene.Box():
                    self._fill(_outline(shape), shape.color)

    def _blit(self, sprite: Any, x: int, y: int) -> None:
        place = (x - sprite.origin_x, y - sprite.origin_y)
        self._surface.blit(sprite.surface, place, special_flags=pygame.BLEND_PREMULTIPLIED)

    def _ring(self, shape: scene.Ring) -> None:
        if shape.radius <= _WIDEST_RING:
            self._blit(*self._sprites.ring(shape))
        elif shape.radius < 4 * max(self.pixels.shape):  # wider than that, its line is out of sight
            centre = (round(shape.x * 16 - 8), round(shape.y * 16 - 8))
            cv2.circle(
                self.pixels,
                centre,
                round(shape.radius * 16),
                (*shape.color, 255),
                round(max(1, shape.width)),
                cv2.LINE_AA,
                _SHIFT,
            )

    def _stroke(self, shape: scene.Stroke) -> None:
        color = (*shape.color, 255)
        start = (round(shape.x0 * 16 - 8), round(shape.y0 * 16 - 8))
        end = (round(shape.x1 * 16 - 8), round(shape.y1 * 16 - 8))
        cv2.line(self.pixels, start, end, color, max(1, round(shape.width)), cv2.LINE_AA, _SHIFT)

    def _fill(self, points: NDArray[np.float64], color: scene.Color) -> None:
        # cv2 counts from pixels' middles, shapes from their edges
        fixed = np.round(points * 16.0 - 8.0).astype(np.int32)
        cv2.fillPoly(self.pixels, [fixed], (*color, 255), cv2.LINE_AA, _SHIFT)


_QUARTER: Final = np.linspace(0.0, np.pi / 2.0, 9)


def _outline(box: scene.Box) -> NDArray[np.float64]:
    """A box's outline, drawn in by half a pixel, since cv2's areas reach half a pixel further than their points."""
    left, top, right, bottom = box.left + 0.5, box.top + 0.5, box.left + box.width - 0.5, box.top + box.height - 0.5
    radius = min(box.radius, (right - left) / 2.0, (bottom - top) / 2.0)
    if radius <= 0.3:
        return np.array([(left, top), (right, top), (right, bottom), (left, bottom)])
    across, up = radius * np.cos(_QUARTER), radius * np.sin(_QUARTER)
    x = np.concatenate([right - radius + across, left + radius - up, left + radius - across, right - radius + up])
    y = np.concatenate([bottom - radius + up, bottom - radius + across, top + radius - up, top + radius - across])
    return np.stack([x, y], axis=1)


class Ground:
    """The arena's floor with its trails, which fade to a faint trace and at last to nothing."""

    def __init__(self, view: scene.Viewport, sprites: SpriteCache) -> None:
        self.view = view
        clean = Canvas.blank(view.width, view.height, scene.OUTSIDE, sprites)
        clean.draw(scene.ground_shapes(view))
        self._clean = clean.pixels
        self._trace = Canvas.blank(view.width, view.height, scene.OUTSIDE, sprites)
        self._floor = Canvas.blank(view.width, view.height, scene.OUTSIDE, sprites)
        # kept, since a new megabyte for every fade costs more than the fade
        self._above, self._below = np.empty_like(self._clean), np.empty_like(self._clean)
        self._time_ms = 0.0
        self.reset()

    @property
    def pixels(self) -> Pixels:
        """(height, width, 4)."""
        return self._floor.pixels

    def reset(self, time_ms: float = 0.0) -> None:
        """No trails."""
        self._trace.pixels[:] = self._clean
        self._floor.pixels[:] = self._clean
        self._time_ms = time_ms

    def trail(self, seat_color: scene.Color, start: scene.Pose, end: scene.Pose) -> None:
        """A hunter went that way."""
        fresh, trace = scene.trail_shapes(self.view, seat_color, start, end)
        self._trace.draw((trace,))
        self._floor.draw((fresh,))

    def fade(self, time_ms: float) -> None:
        """Fade as much as so late an instant asks for; after long waits there is nothing left to fade."""
        for layer, goal, every, part in (
            (self._trace.pixels, self._clean, TRACE_FADE_MS, 0.012),
            (self._floor.pixels, self._trace.pixels, FADE_MS, 0.048),
        ):
            times = int(time_ms // every) - int(self._time_ms // every)
            for _ in range(min(times, 150)):
                self._approach(layer, goal, part)
        self._time_ms = time_ms

    def _approach(self, layer: Pixels, goal: Pixels, part: float) -> None:
        """Move every byte of a layer by that part of its way to the goal, and by 1 at least: it gets there exactly."""
        above, below = self._above, self._below
        cv2.subtract(layer, goal, above)
        cv2.subtract(goal, layer, below)
        # rounding 0.49 + part * way leaves 0 at 0 and makes 1 of the least way
        cv2.convertScaleAbs(above, above, part, 0.49)
        cv2.convertScaleAbs(below, below, part, 0.49)
        cv2.subtract(layer, above, layer)
        cv2.add(layer, below, layer)


class Stage:
    """A match's frames, one after the other, in one buffer: `enter` each step, then `draw` the instants in it."""

    def __init__(self, look: scene.Look, size: tuple[int, int], layout: hud.Layout, seed: int | None = None) -> None:
        if layout not in get_args(hud.Layout):
            raise ConfigError(
                f"layout must be broadcast or arena, got {layout!r}; {suggest(layout, get_args(hud.Layout))}"
            )
        self.look = look
        self._seed = seed
        self._plan = hud.arrange(size, layout, look.config.hunters)
        self._sprites = SpriteCache()
        self._frame = Canvas.blank(*size, hud.PANEL, self._sprites)
        self._arena = self._frame.part(self._plan.arena)
        self._ground = Ground(scene.Viewport(*self._plan.arena[2:], look.config.side_m), self._sprites)
        self.reset()

    @property
    def pixels(self) -> Pixels:
        """(height, width, 4): the shared buffer, whose fourth byte means nothing; the next `draw` overwrites it."""
        return self._frame.pixels

    def reset(self, time_ms: float = 0.0) -> None:
        """A new match: no trails, no marks."""
        self._ground.reset(time_ms)
        self._marks: list[scene.Mark] = []
        self._timeline = hud.Timeline(self.look.duration_ms)
        self._standings: tuple[hud.Standing, ...] = ()
        self._last_poses: tuple[scene.Pose, ...] | None = None
        self._shown: dict[str, object] = {}

    def enter(self, now: Leg) -> None:
        """Begin a step: its rulings count from here on."""
        marks = scene.marks_of(now.before, now.after)
        self._marks += marks
        self._standings = tuple(
            hud.Standing(seat, hunter.score, hunter.withdrawn) for seat, hunter in enumerate(now.after.hunters)
        )
        catchers = [mark.seat for mark in marks if mark.kind == "catch"]
        self._timeline.tell(now.before.time_ms, catchers, [one.score for one in self._standings])
        if self._last_poses is None:
            self._last_poses = now.poses[0]

    def move(self, poses: tuple[scene.Pose, ...]) -> None:
        """The hunters went there in a straight line: their trails follow."""
        if self._last_poses is not None:
            for seat, (start, end) in enumerate(zip(self._last_poses, poses, strict=True)):
                if start[:2] != end[:2]:
                    self._ground.trail(self.look.color(seat), start, end)
        self._last_poses = poses

    def draw(self, now: Leg, time_ms: float, poses: tuple[scene.Pose, ...]) -> Pixels:
        """Draw one instant of a step into the buffer."""
        self._ground.fade(time_ms)
        self.move(poses)
        self._marks = scene.still_seen(self._marks, time_ms)
        targets = [target for target in now.after.targets if target.spawned_ms <= time_ms]
        self._arena.pixels[:] = self._ground.pixels
        self._arena.draw(
            scene.arena_shapes(
                self._ground.view,
                self.look,
                hunters=now.after.hunters,
                poses=poses,
                targets=targets,
                marks=self._marks,
                time_ms=time_ms,
            )
        )
        self._draw_around(time_ms)
        return self.pixels

    def _draw_around(self, time_ms: float) -> None:
        """The panel's parts, each only when it would look different."""
        plan, unit = self._plan, self._plan.unit
        clock = hud.clock(time_ms)
        if not plan.standings.width:
            chips, right = hud.split_strip(plan.header, clock)
            if self._changed("chips", (chips, self._standings)):
                self._redraw(chips, hud.chip_shapes(chips, self.look, self._standings))
            if self._changed("clock", clock):
                self._redraw(right, hud.strip_clock_shapes(right, clock))
            return
        if self._changed("header", clock):
            self._redraw(plan.header, hud.header_shapes(plan.header, self.look, self._seed, clock, unit))
        if self._changed("standings", self._standings):
            self._redraw(plan.standings, hud.standings_shapes(plan.standings, self.look, self._standings, unit))
        cursor = round(hud.cursor_x(plan.timeline, self._timeline, time_ms, unit))
        if self._changed("timeline", (cursor, self._timeline.catches)):
            self._redraw(plan.timeline, hud.timeline_shapes(plan.timeline, self.look, self._timeline, time_ms, unit))

    def _changed(self, part: str, state: object) -> bool:
        if self._shown.get(part) == state:
            return False
        self._shown[part] = state
        return True

    def _redraw(self, area: hud.Rect, shapes: list[scene.Shape]) -> None:
        self._frame.pixels[area.top : area.top + area.height, area.left : area.left + area.width] = (*hud.PANEL, 255)
        self._frame.draw(shapes)


class ArenaPainter:
    """One arena's picture at every step that it is shown, for `env.render()`.

    Trails and catches come from the worlds that were painted before; a world of step 0, or one that the last cannot
    have led to, begins anew.

    Args: `config`; `names` by seat; `size`, (width, height) [pixels]; `layout`, "arena" or "broadcast".
    Raises: ConfigError.
    """

    def __init__(
        self,
        config: ArenaConfig,
        names: Sequence[str] | None = None,
        size: tuple[int, int] = (500, 500),
        layout: hud.Layout = "arena",
    ) -> None:
        self._stage = Stage(scene.Look.of(config, names), checked_size(size), layout)
        self._last: World | None = None

    def paint(self, world: World) -> Pixels:
        """A fresh (height, width, 3) uint8 frame of the world as it is now."""
        stage, last = self._stage, self._last
        if last is None or world.step == 0 or world.step < last.step or not self._led_to(last, world):
            stage.reset(float(world.time_ms))
            now = leg(world, world)
            stage.enter(now)
        elif world.step == last.step:
            now = leg(world, world)
        elif world.step == last.step + 1:
            now = leg(last, world)
            stage.enter(now)
            for poses in now.poses[1:]:
                stage.move(poses)
        else:  # steps were left out: their rulings are not known, and the way is a straight line
            now = Leg(last, world, (tuple((hunter.x, hunter.y, hunter.theta) for hunter in world.hunters),))
            stage.enter(now)
        self._last = world
        pixels = stage.draw(now, float(world.time_ms), now.poses[-1])
        return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGBA2RGB), dtype=np.uint8)

    def _led_to(self, last: World, world: World) -> bool:
        """Nobody can have driven further."""
        furthest = self._stage.look.config.max_speed_mps * (world.time_ms - last.time_ms + 16) / 1000.0 + 1e-6
        return all(
            abs(now.x - then.x) <= furthest and abs(now.y - then.y) <= furthest
            for then, now in zip(last.hunters, world.hunters, strict=True)
        )
