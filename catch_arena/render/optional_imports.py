"""Imports of cv2 and pygame, which draw; both are extras, so every module takes them from this one.

pygame comes without its banner; only window.py opens a display.
"""

import os

from catch_arena.errors import ConfigError, install_hint

__all__ = ["cv2", "pygame"]

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
try:
    import cv2
    import pygame
except ImportError as error:
    if error.name not in ("cv2", "pygame"):  # cv2 or pygame is installed but broken
        raise
    raise ConfigError(f"pictures need OpenCV and pygame: {install_hint('render')}") from None
