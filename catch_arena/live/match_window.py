"""Window that shows a match while it is played."""

import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Final

from catch_arena.envs.parallel import CatchArenaEnv
from catch_arena.errors import OutputError
from catch_arena.live import overlays
from catch_arena.live.user_input import HumanPolicy, UserCommand, user_command
from catch_arena.render import hud
from catch_arena.render.captions import panel_shapes
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.optional_imports import pygame
from catch_arena.render.renderer import LARGEST, SMALLEST, MatchRenderer
from catch_arena.render.shapes import Shape
from catch_arena.render.window import Screen
from catch_arena.replay import Replay
from catch_arena.replay.motion import StepMotion, step_motion
from catch_arena.tournament.match_loop import MatchStopped
from catch_arena.world import World

SPEEDS: Final = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
"""Speeds that the user can choose: seconds of the match per second of real time."""
_FPS: Final = 60
_LONGEST_FRAME_MS: Final = 100.0
"""Greatest real time that one frame counts for; after a delay the match does not jump ahead."""
_NOTE_S: Final = 3.0
_POINTED_MS: Final = 3000
_SETTLED_S: Final = 0.2
"""Time after which a resized window is drawn at its new size [s]."""


class RestartRequested(Exception):  # noqa: N818 - no error: a person's request
    """Request of the window's user to play the match from its beginning."""


class MatchWindow:
    """Window for a match at its own pace, which `tournament.match_loop.play_match` takes as `watch`.

    Between two steps it draws the way from one to the other, while the person steers the next step. Its calls raise
    MatchStopped if its user ends the match, and RestartRequested. `person` gets the window's events; `seat` is None
    without a person. `save` gets the replay so far, and returns a text that says where it is.
    """

    def __init__(
        self,
        info: MatchInfo,
        seed: int,
        size: tuple[int, int],
        person: HumanPolicy,
        seat: int | None,
        save: Callable[[Replay], str],
    ) -> None:
        self._info, self._seed = info, seed
        self._person, self._seat, self._save = person, seat, save
        self._screen = Screen(f"Catch Arena: {info.title}", size)
        pygame.joystick.init()
        self._pads = [pygame.joystick.Joystick(index) for index in range(pygame.joystick.get_count())]
        self._clock = pygame.time.Clock()
        self._renderer = self._new_renderer(size)
        self._motions: list[StepMotion] = []
        self._size, self._size_since_s = size, 0.0
        self._stopped = self._paused = self._shows_help = False
        self._has_shown_help = seat is None
        self._speed = SPEEDS.index(1.0)
        self._note, self._note_until_s = "", 0.0
        self.notify("H: show the keys")

    @property
    def replay(self) -> Replay:
        """Replay of the steps played so far."""
        return self._env.replay()

    def __call__(self, env: CatchArenaEnv) -> None:
        """Show the next state of the match; the first one begins it."""
        self._env = env
        world = env.world()
        self._renderer.observe(world.step, env.hunter_observations())
        if world.step == 0:
            self._begin(world)
            return
        motion = step_motion(self._motion.after, world)
        self._motions.append(motion)
        self._renderer.enter(motion)
        self._run()

    @property
    def _motion(self) -> StepMotion:
        return self._motions[-1]

    def wait(self) -> None:
        """Draw one frame while an agent takes long, with the match as played until now."""
        time_ms = self._motion.after.time_ms
        self._draw(time_ms, self._pointer(time_ms) + self._line("waiting for an agent"))
        self._clock.tick()  # the match does not advance in this time

    def notify(self, text: str) -> None:
        """Show a line of text for some seconds."""
        self._note, self._note_until_s = text, time.monotonic() + _NOTE_S

    def close(self) -> None:
        """Close the window."""
        pygame.joystick.quit()
        self._screen.close()

    def _begin(self, world: World) -> None:
        motion = step_motion(world, world)
        self._motions = [motion]
        self._renderer.reset()
        self._renderer.enter(motion)
        self._ahead_ms = 0.0
        self._steps = 0
        self._paused = self._shows_help = False
        while not self._has_shown_help:
            for event in self._draw(0.0, self._keys_overlay("press any key to begin")):
                if event.type in {pygame.KEYDOWN, pygame.JOYBUTTONDOWN} and not getattr(event, "mod", 0):
                    self._has_shown_help = True
            self._clock.tick(_FPS)
        self._clock.tick()

    def _run(self) -> None:
        """Show the latest step from its beginning to its end; a pause holds it at the end."""
        time_ms = self._motion.before.time_ms + self._ahead_ms
        end_ms = self._motion.after.time_ms
        while time_ms < end_ms:
            self._draw(time_ms, self._overlays(time_ms))
            time_ms += min(_LONGEST_FRAME_MS, self._clock.tick(_FPS)) * SPEEDS[self._speed]
        self._ahead_ms = time_ms - end_ms
        self._steps = max(0, self._steps - 1)
        while self._paused and not self._steps:
            self._draw(end_ms, self._overlays(end_ms))
            self._clock.tick(_FPS)
            self._ahead_ms = 0.0

    def show_podium(self) -> None:
        """Show the podium until the user quits or restarts, unless the user has quit."""
        keys = self._line("R: restart    Ctrl-S: save    Esc: quit")
        with suppress(MatchStopped):
            while not self._stopped:
                self._draw(self._motion.after.time_ms, self._note_shapes() or keys, podium=True)
                self._clock.tick(_FPS)

    def _draw(self, time_ms: float, over: list[Shape], *, podium: bool = False) -> list[Any]:
        """Draw a frame of the latest step, under the podium at the end, and handle and return the events."""
        self._renderer.draw(time_ms, self._motion.at(time_ms))
        if podium:
            self._renderer.draw_podium()
        self._renderer.draw_over(over)
        self._screen.show(self._renderer.pixels)
        return self._events()

    def _events(self) -> list[Any]:
        """Handle the events since the last call and return them."""
        events = list(pygame.event.get())
        for event in events:
            self._person.handle(event)
            if event.type == pygame.JOYDEVICEADDED:
                self._pads.append(pygame.joystick.Joystick(event.device_index))
            command = user_command(event)
            if command is not None:
                self._execute(command)
        self._fit()
        return events

    def _execute(self, command: UserCommand) -> None:
        if command == "quit":
            self._stopped = True
            raise MatchStopped
        if command == "restart":
            raise RestartRequested
        if command == "pause":
            self._paused, self._shows_help = not self._paused, False
        elif command == "step":
            self._steps += self._paused
        elif command == "help":
            self._paused = self._shows_help = not self._shows_help
        elif command == "save":
            self._save_replay()
        elif command == "view":
            self._show_next_view()
        else:
            faster = 1 if command == "faster" else -1
            self._speed = min(max(0, self._speed + faster), len(SPEEDS) - 1)
            self.notify(f"speed {SPEEDS[self._speed]:g}")

    def _show_next_view(self) -> None:
        """Switch to the next view: the person's own first, then those of the other hunters, then none."""
        hunters = self._info.config.hunters
        if not self._info.config.limits_views:
            self.notify("all hunters see the whole arena")
            return
        first = self._seat if self._seat is not None and self._seat < hunters else 0
        views = [*range(first, hunters), *range(first), None]
        view = views[(views.index(self._renderer.view_of) + 1) % len(views)]
        self._renderer.view_of = view
        self.notify("no hunter's view" if view is None else f"the view of {self._info.names[view]}")

    def _save_replay(self) -> None:
        try:
            self.notify(f"saved: {self._save(self.replay)}")
        except OutputError as error:
            self.notify(str(error))

    def _overlays(self, time_ms: float) -> list[Shape]:
        shapes = self._pointer(time_ms)
        if self._shows_help:
            return shapes + self._keys_overlay("H: continue")
        if self._paused:
            return shapes + self._line("paused    space: continue    N: one step    H: keys")
        return shapes + (self._note_shapes() or self._out_shapes())

    def _out_shapes(self) -> list[Shape]:
        """R12.3: return a note that the person's prey is out, and until when; no shapes if it is not out."""
        index = -1 if self._seat is None else self._seat - self._info.config.hunters
        caught_ms = self._motion.after.prey[index].caught_ms if index >= 0 else None
        if caught_ms is None:
            return []
        after_ms = self._info.config.prey_returns_ms
        until = "" if after_ms is None else f": you return at {(caught_ms + after_ms) / 1000:.1f} s"
        return self._line(f"you are out{until}")

    def _pointer(self, time_ms: float) -> list[Shape]:
        """Return a pointer to the person's agent: in the first seconds, in a pause, and when its prey has returned."""
        if self._seat is None:
            return []
        poses, since_ms = self._motion.at(time_ms), 0
        if self._seat < self._info.config.hunters:
            place = poses.hunters[self._seat]
        else:
            name = self._info.config.prey_names[self._seat - self._info.config.hunters]
            target = next((state for state in self._motion.after.targets if state.prey == name), None)
            if target is None:
                return []
            place, since_ms = poses.targets[target.number], target.spawned_ms
        if not (0 <= time_ms - since_ms < _POINTED_MS or self._paused):
            return []
        return overlays.seat_pointer(self._renderer.viewport, place[:2], self._info.colors[self._seat])

    def _keys_overlay(self, below: str) -> list[Shape]:
        rows = overlays.WINDOW if self._seat is None else (*overlays.DRIVING, *overlays.WINDOW)
        return overlays.keys_overlay(self._renderer.viewport, rows, below)

    def _note_shapes(self) -> list[Shape]:
        return self._line(self._note) if time.monotonic() < self._note_until_s else []

    def _line(self, text: str) -> list[Shape]:
        return panel_shapes(self._renderer.viewport, hud.DIM, text, at_top=False)

    def _new_renderer(self, size: tuple[int, int]) -> MatchRenderer:
        width, height = (min(max(SMALLEST, part), largest) for part, largest in zip(size, LARGEST, strict=True))
        self._drawn_size = size
        return MatchRenderer(self._info, (width, height), "broadcast", self._seed)

    def _fit(self) -> None:
        """Replace the renderer if the window keeps a new size, and enter all past motions into the new one."""
        size, now_s = self._screen.size, time.monotonic()
        if size != self._size:
            self._size, self._size_since_s = size, now_s
        elif size != self._drawn_size and now_s - self._size_since_s > _SETTLED_S:
            view, self._renderer = self._renderer.view_of, self._new_renderer(size)
            self._renderer.view_of = view
            for past in self._motions:
                self._renderer.enter(past)
            self._clock.tick()
