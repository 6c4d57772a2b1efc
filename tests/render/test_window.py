"""The plain window of render_mode="human", on SDL's driver for machines without a screen."""

import time

import numpy as np
import pytest

from catch_arena.errors import OutputError
from catch_arena.render.sdl import pygame
from catch_arena.render.window import Window

FRAME = np.full((320, 400, 3), 77, dtype=np.uint8)


@pytest.fixture
def driver(monkeypatch):
    """SDL's driver by name; none is left open."""
    yield lambda name: monkeypatch.setenv("SDL_VIDEODRIVER", name)
    pygame.display.quit()


def test_it_opens_with_its_first_frame_and_shows_it(driver):
    driver("dummy")
    window = Window("Catch Arena", (400, 320), 0.0)
    assert not pygame.display.get_init()
    window.show(FRAME)
    assert pygame.display.get_surface().get_at((5, 5))[:3] == (77, 77, 77)
    assert pygame.display.get_caption()[0] == "Catch Arena"
    window.close()
    assert not pygame.display.get_init()


def test_frames_keep_the_pace_of_the_match(driver):
    driver("dummy")
    window = Window("Catch Arena", (400, 320), 40.0)
    window.show(FRAME)
    began = time.perf_counter()
    for _ in range(5):
        window.show(FRAME)
    assert 0.19 <= time.perf_counter() - began < 0.6
    window.close()


def test_a_late_match_does_not_hurry_afterwards(driver):
    driver("dummy")
    window = Window("Catch Arena", (400, 320), 40.0)
    window.show(FRAME)
    time.sleep(0.3)
    window.show(FRAME)
    began = time.perf_counter()
    window.show(FRAME)
    assert time.perf_counter() - began >= 0.03
    window.close()


def test_when_its_user_closes_it_the_match_goes_on_without_it(driver):
    driver("dummy")
    window = Window("Catch Arena", (400, 320), 10_000.0)
    window.show(FRAME)
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    began = time.perf_counter()
    for _ in range(3):
        window.show(FRAME)
    assert window.closed
    assert not pygame.display.get_init()
    assert time.perf_counter() - began < 5.0
    window.close()


def test_without_a_display_it_says_so(driver):
    driver("no_such_driver")
    window = Window("Catch Arena", (400, 320), 10.0)
    with pytest.raises(OutputError, match="needs a display"):
        window.show(FRAME)
