"""Windows: a picture on the screen that its user may resize, and the plain window for render_mode="human"."""

import os
import time
from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.errors import OutputError
from catch_arena.render.hud import PANEL
from catch_arena.render.optional_imports import pygame

_FPS: Final = 60
_SOON_S: Final = 1e-3
"""Rest of a step that is too short for a picture of its own [s]."""


class Screen:
    """Window on the screen; only one can be open. Raises OutputError without a display."""

    def __init__(self, title: str, size: tuple[int, int]) -> None:
        try:
            pygame.display.init()
            pygame.display.set_mode(size, pygame.RESIZABLE)
            if pygame.display.get_driver() == "offscreen" and os.environ.get("SDL_VIDEODRIVER") != "offscreen":
                # SDL uses this driver if there is no display, though it was not asked for
                raise pygame.error("none was found")
        except pygame.error as error:
            self.close()
            raise OutputError(
                f'a window needs a display: {error}; render_mode "rgb_array" and videos work without one'
            ) from None
        pygame.display.set_caption(title)

    @property
    def size(self) -> tuple[int, int]:
        """Current (width, height) [pixels], which the user may change."""
        width, height = pygame.display.get_window_size()
        return width, height

    def show(self, pixels: NDArray[np.uint8]) -> None:
        """Show a picture, (height, width, 4), scaled to the window; the fourth channel is ignored."""
        height, width, _ = pixels.shape
        picture = pygame.image.frombuffer(pixels.data, (width, height), "RGBX")
        surface = pygame.display.get_surface()
        if surface is None:
            return
        room = surface.get_size()
        if room != (width, height):
            part = min(room[0] / width, room[1] / height)
            width, height = max(1, round(part * width)), max(1, round(part * height))
            picture = pygame.transform.smoothscale(picture, (width, height))
            surface.fill(PANEL)
        surface.blit(picture, ((room[0] - width) // 2, (room[1] - height) // 2))
        pygame.display.flip()

    def close(self) -> None:
        """Close the window."""
        pygame.display.quit()


class Window:
    """Window that shows an env's match while it is stepped, in motion and at the match's own pace.

    After its user closes it, it stays closed: further steps are not shown, and the match goes on without waiting for
    real time.
    """

    def __init__(self, title: str, size: tuple[int, int]) -> None:
        self._screen = Screen(title, size)
        self._due_s = 0.0
        self.closed = False
        """True after the user or `close` has closed the window."""

    def play(self, picture: Callable[[float], NDArray[np.uint8]], lasts_ms: float) -> None:
        """Show a step from its beginning to its end, then return; a late step is shown in the rest of its time.

        `picture` draws (height, width, 4) at a part of the step in (0, 1]. A picture that follows no other lasts 0 ms.
        """
        lasts_s, frame_s = lasts_ms / 1000.0, time.perf_counter()
        self._due_s = max(self._due_s, frame_s - lasts_s) + lasts_s  # a delayed match does not hurry afterwards
        part = 0.0
        while part < 1.0 and not self.closed:
            frame_s += 1.0 / _FPS
            time.sleep(max(0.0, min(frame_s, self._due_s) - time.perf_counter()))
            if any(event.type == pygame.QUIT for event in pygame.event.get()):
                self.close()
                return
            left_s = self._due_s - time.perf_counter()
            part = 1.0 - left_s / lasts_s if left_s > _SOON_S else 1.0
            self._screen.show(picture(part))

    def close(self) -> None:
        """Close the window, if it is open."""
        if not self.closed:
            self.closed = True
            self._screen.close()
