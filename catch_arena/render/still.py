"""Single pictures: as PNG, and as an element of a page."""

import base64
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.render.libraries import cv2
from catch_arena.render.raster import Pixels
from catch_arena.render.stage import ArenaPainter
from catch_arena.world import World

NOTEBOOK_SIZE: Final = (800, 450)


def png(pixels: Pixels) -> bytes:
    """A (height, width, 3 or 4) picture, red first, as a PNG file; the fourth byte means nothing."""
    order = cv2.COLOR_RGB2BGR if pixels.shape[2] == 3 else cv2.COLOR_RGBA2BGR
    return bytes(cv2.imencode(".png", cv2.cvtColor(pixels, order))[1])


def png_html(config: ArenaConfig, world: World) -> str:
    """An arena as it is now, with its standings, as an image that a page holds itself."""
    content = png(ArenaPainter(config, size=NOTEBOOK_SIZE, layout="broadcast").paint(world))
    about = f"step {world.step}, {world.time_ms / 1000:.1f} s"
    return f'<img alt="Catch Arena, {about}" src="data:image/png;base64,{base64.b64encode(content).decode()}">'
