"""cv2 and pygame, which draw: every module takes them from this one, since both are extras. pygame comes without its
banner; nothing opens a display but window.py.
"""

import os

from catch_arena.errors import ConfigError, install_hint

__all__ = ["cv2", "pygame"]

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
try:
    import cv2
    import pygame
except ImportError as error:
    if error.name not in ("cv2", "pygame"):  # one is there, and broken
        raise
    raise ConfigError(f"pictures need OpenCV and pygame: {install_hint('render')}") from None
