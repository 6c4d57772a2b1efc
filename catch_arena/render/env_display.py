"""Display of an env: frames, a window, and the HTML for notebooks."""

from html import escape
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig, require_choice
from catch_arena.errors import ConfigError
from catch_arena.replay import Replay
from catch_arena.world import World

RENDER_MODES: Final = ("rgb_array", "human")
RENDER_SIZE: Final = (500, 500)
"""Size of the frames that `render` returns, width and height [pixels]: that of turtlesim's window."""


class Display:
    """Painter of an arena in one of RENDER_MODES, or None to draw nothing. A copied or unpickled one has no window yet.

    Raises:
        ConfigError: for another mode, and for one whose libraries are missing.
    """

    def __init__(self, config: ArenaConfig, mode: str | None) -> None:
        require_choice("render_mode", mode, (None, *RENDER_MODES))
        if mode is not None:
            import catch_arena.render.optional_imports  # noqa: F401 - raises now if libraries are missing
        self._config, self._mode = config, mode
        self._painter: Any = None
        self._window: Any = None

    def __reduce__(self) -> tuple[Any, ...]:
        return Display, (self._config, self._mode)

    def render(self, world: World) -> NDArray[np.uint8] | None:
        """Draw a world: see `CatchArenaEnv.render`."""
        from catch_arena.render.renderer import ArenaPainter

        if self._painter is None:
            self._painter = ArenaPainter(self._config, size=RENDER_SIZE)
        if self._mode == "rgb_array":
            frame: NDArray[np.uint8] = self._painter.paint(world)
            return frame
        from catch_arena.render.window import Window

        if self._window is None:
            self._window = Window("Catch Arena", RENDER_SIZE)
        self._window.play(self._painter.draw, self._painter.enter(world))
        return None

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()
            self._window = None


def notebook_html(title: str, config: ArenaConfig, world: World | None, replay: Replay | None) -> str:
    """Return the HTML that a notebook shows: a player of the recorded episode, else a picture of the current arena."""
    if replay is not None and replay.steps:
        return replay._repr_html_()
    if world is None:
        return f"<p>{escape(title)}: no episode has begun</p>"
    try:
        from catch_arena.render.renderer import png_html
    except ConfigError as error:  # without the libraries that draw
        return f"<p>{escape(title)}: {escape(str(error))}</p>"
    return png_html(config, world)
