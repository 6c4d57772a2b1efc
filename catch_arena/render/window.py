"""Windows: a picture on the screen that its user may resize, and the plain window for render_mode="human"."""

import os
import sys
import time
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.errors import OutputError
from catch_arena.render.hud import PANEL
from catch_arena.render.sdl import pygame

_NAP_S: Final = 0.02
"""The window answers its user at least so often."""


class Screen:
    """A window. Only one can be open.

    Args: `title`; `size`, (width, height) [pixels] to begin with. Raises: OutputError without a display.
    """

    def __init__(self, title: str, size: tuple[int, int]) -> None:
        try:
            pygame.display.init()
            pygame.display.set_mode(size, pygame.RESIZABLE)
        except pygame.error as error:
            raise OutputError(
                f'a window needs a display to open on: {error}; render_mode "rgb_array" and videos do not'
            ) from None
        if pygame.display.get_driver() == "offscreen" and os.environ.get("SDL_VIDEODRIVER") != "offscreen":
            # SDL's last resort where there is no display, which nobody asked for
            sys.stderr.write(
                'catch_arena: there is no display, so that nobody sees the window; "rgb_array" needs none\n'
            )
        pygame.display.set_caption(title)

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) [pixels], as its user has made it."""
        width, height = pygame.display.get_window_size()
        return width, height

    def show(self, pixels: NDArray[np.uint8]) -> None:
        """A (height, width, 3 or 4) picture, as large as the window has room for; the fourth byte means nothing."""
        height, width, channels = pixels.shape
        picture = pygame.image.frombuffer(
            np.ascontiguousarray(pixels).data, (width, height), "RGB" if channels == 3 else "RGBX"
        )
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
    """Frames on the screen, at the pace of the match.

    It opens with its first frame. When its user closes it, it stays closed: further frames are dropped and the match
    goes on, no longer held to real time.

    Args: `title`; `size`, (width, height) [pixels]; `period_ms`, how long each frame stays.
    """

    def __init__(self, title: str, size: tuple[int, int], period_ms: float) -> None:
        self._title = title
        self._size = size
        self._period_s = period_ms / 1000.0
        self._screen: Screen | None = None
        self._due_s = 0.0
        self.closed = False
        """Its user, or `close`, has closed it."""

    def show(self, frame: NDArray[np.uint8]) -> None:
        """Show a (height, width, 3) frame once the last one has had its time. Raises: OutputError without a display."""
        if self.closed:
            return
        if self._screen is None:
            try:
                self._screen = Screen(self._title, self._size)
            except OutputError:
                self.closed = True
                raise
            self._due_s = time.perf_counter()
        self._wait_until_due()
        if not self.closed:
            self._screen.show(frame)

    def close(self) -> None:
        """Close the window, if it is open."""
        self.closed = True
        if self._screen is not None:
            self._screen.close()
            self._screen = None

    def _wait_until_due(self) -> None:
        while True:
            if any(event.type == pygame.QUIT for event in pygame.event.get()):
                self.close()
                return
            wait_s = self._due_s - time.perf_counter()
            if wait_s <= 0.0:
                break
            time.sleep(min(wait_s, _NAP_S))
        now = time.perf_counter()
        late = now - self._due_s > self._period_s
        # a match that runs a little late makes up for it; one that was held up does not hurry afterwards
        self._due_s = (now if late else self._due_s) + self._period_s
