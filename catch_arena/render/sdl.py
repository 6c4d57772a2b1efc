"""pygame without its banner: every module here takes it from this one. Nothing opens a display but window.py."""

import os

__all__ = ["pygame"]

_HUSH = "PYGAME_HIDE_SUPPORT_PROMPT"

_was_set = _HUSH in os.environ
os.environ.setdefault(_HUSH, "1")
try:
    import pygame
finally:
    if not _was_set:  # child processes find the environment as it was
        del os.environ[_HUSH]
