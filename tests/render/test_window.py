"""The window of render_mode="human" keeps the pace of the match, on a machine without a screen."""

from itertools import pairwise

import numpy as np
import pytest

import catch_arena
from catch_arena.errors import OutputError
from catch_arena.render.optional_imports import pygame
from catch_arena.render.window import Window

FRAME = np.full((320, 400, 4), 77, dtype=np.uint8)


class Clock:
    """Stands still but for those who sleep."""

    now_s = 100.0

    def perf_counter(self) -> float:
        return self.now_s

    def sleep(self, seconds: float) -> None:
        self.now_s += seconds


class Pictures:
    """A step's pictures, each of one grey, and each takes a while; the parts that were asked for."""

    def __init__(self, clock: Clock, takes_s: float = 0.0) -> None:
        self.clock, self.takes_s = clock, takes_s
        self.parts: list[float] = []

    def __call__(self, part: float) -> np.ndarray:
        self.clock.sleep(self.takes_s)
        self.parts.append(part)
        return FRAME


@pytest.fixture
def driver(monkeypatch):
    """SDL's driver by name; none is left open."""
    yield lambda name: monkeypatch.setenv("SDL_VIDEODRIVER", name)
    pygame.display.quit()


@pytest.fixture
def clock(monkeypatch):
    """The window's."""
    ticking = Clock()
    monkeypatch.setattr("catch_arena.render.window.time", ticking)
    return ticking


@pytest.fixture
def window(driver, clock):
    """A window that shows a match's beginning."""
    driver("dummy")
    opened = Window("Catch Arena", (400, 320))
    opened.play(Pictures(clock), 0.0)
    yield opened
    opened.close()


def test_it_opens_and_shows_its_picture(driver, clock):
    driver("dummy")
    window = Window("Catch Arena", (400, 320))
    pictures = Pictures(clock)
    window.play(pictures, 0.0)
    assert pictures.parts == [1.0]
    assert pygame.display.get_surface().get_at((5, 5))[:3] == (77, 77, 77)
    assert pygame.display.get_caption()[0] == "Catch Arena"
    window.close()
    assert not pygame.display.get_init()


def test_a_step_moves_evenly_to_its_end_sixty_times_a_second_and_takes_its_time(window, clock):
    pictures = Pictures(clock, takes_s=0.003)
    for _ in range(3):
        window.play(pictures, 100.0)
    assert pictures.parts == pytest.approx([1 / 6, 2 / 6, 3 / 6, 4 / 6, 5 / 6, 1.0] * 3, abs=0.031)
    assert clock.now_s == pytest.approx(100.303)  # each step's last picture begins when its time is over


def test_slow_drawing_leaves_pictures_out_and_does_not_hold_up_the_match(window, clock):
    pictures = Pictures(clock, takes_s=0.04)
    for _ in range(10):
        window.play(pictures, 100.0)
    assert 100.99 < clock.now_s < 101.1
    assert pictures.parts.count(1.0) == 10
    assert len(pictures.parts) >= 20


def test_when_its_user_closes_it_the_match_goes_on_without_it(window, clock):
    pictures = Pictures(clock)
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    for _ in range(3):
        window.play(pictures, 10_000.0)
    assert window.closed
    assert not pygame.display.get_init()
    assert not pictures.parts
    assert clock.now_s < 101.0


def test_without_a_display_it_says_so_each_time(driver):
    driver("no_such_driver")
    env = catch_arena.parallel_env("duel", render_mode="human")
    for _ in range(2):
        with pytest.raises(OutputError, match="needs a display"):
            env.reset(seed=3)


def test_an_env_shows_the_way_between_its_steps(driver, clock, monkeypatch):
    driver("dummy")
    shown = []
    monkeypatch.setattr("catch_arena.render.window.Screen.show", lambda _, pixels: shown.append(pixels.copy()))
    env = catch_arena.parallel_env("duel", render_mode="human")
    assert not pygame.display.get_init()
    env.reset(seed=3)
    for _ in range(3):
        env.step(dict.fromkeys(env.agents, 1))
    assert len(shown) == 1 + 3 * 6
    assert all(not np.array_equal(one, other) for one, other in pairwise(shown))
    assert clock.now_s == pytest.approx(100.3)
    env.close()
