"""A plain window for render_mode="human"."""

import os
import sys
import time
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.errors import OutputError
from catch_arena.render.sdl import pygame

_NAP_S: Final = 0.02
"""The window answers its user at least so often."""


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
        self._screen: pygame.Surface | None = None
        self._due_s = 0.0
        self.closed = False
        """Its user, or `close`, has closed it."""

    def show(self, frame: NDArray[np.uint8]) -> None:
        """Show a (height, width, 3) frame once the last one has had its time. Raises: OutputError without a display."""
        if self.closed:
            return
        if self._screen is None:
            self._open()
        self._wait_until_due()
        if self.closed or self._screen is None:
            return
        height, width = frame.shape[:2]
        picture = pygame.image.frombuffer(np.ascontiguousarray(frame).data, (width, height), "RGB")
        self._screen.blit(picture, (0, 0))
        pygame.display.flip()

    def close(self) -> None:
        """Close the window, if it is open."""
        self.closed = True
        if self._screen is not None:
            self._screen = None
            pygame.display.quit()

    def _open(self) -> None:
        try:
            pygame.display.init()
            self._screen = pygame.display.set_mode(self._size)
        except pygame.error as error:
            self.closed = True
            raise OutputError(
                f'render_mode "human" needs a display to open a window on: {error}; "rgb_array" does not'
            ) from None
        if pygame.display.get_driver() == "offscreen" and os.environ.get("SDL_VIDEODRIVER") != "offscreen":
            # SDL's last resort where there is no display, which nobody asked for
            sys.stderr.write(
                'catch_arena: there is no display, so that nobody sees the window; "rgb_array" needs none\n'
            )
        pygame.display.set_caption(self._title)
        self._due_s = time.perf_counter()

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
