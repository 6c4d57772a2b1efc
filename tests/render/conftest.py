"""Matches that the tests of this folder draw, and videos of one that several of them look at."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from render.matches import played
from render.videos import SMALL, drawn

from catch_arena.render.video import RenderReport, render_replay
from catch_arena.replay import Replay


@pytest.fixture(scope="session")
def play() -> Callable[..., Replay]:
    """Plays a match in which everybody chases the nearest target, with any settings."""
    return played


@pytest.fixture(scope="session")
def match(play) -> Replay:
    """Four hunters, three seconds."""
    return play(time_limit_s=3.0, names=("contested", "nearest", "patrol", "first"), title="Round 1")


@pytest.fixture(scope="session", params=["wander", "flee"])
def moving(play, request) -> Replay:
    """Six seconds in which targets move, appear, meet the walls and are caught; a step is no whole number of ticks."""
    return play(
        time_limit_s=6.0,
        target_motion=request.param,
        spawn_frequency_hz=3.0,
        target_turn_rate_radps=2.0,
        target_speed_mps=1.5,
        control=("target", "velocity", "full", "target"),
    )


@pytest.fixture(scope="session")
def worlds(match) -> list:
    """Worlds of the match, step by step."""
    return list(match.worlds())


@pytest.fixture(scope="session")
def frames(match) -> Callable[[str], list[np.ndarray]]:
    """The match's frames in a layout, as they are drawn for a small video."""
    return cache(lambda layout: drawn(match, layout=layout, **SMALL))


@pytest.fixture(scope="session")
def video(match, tmp_path_factory) -> Callable[[str, str], RenderReport]:
    """A small video of the match, by the ending of its file and the layout."""

    def rendered(ending: str, layout: str) -> RenderReport:
        return render_replay(
            match, tmp_path_factory.mktemp("video") / f"match{ending}", start_s=0.0, layout=layout, **SMALL
        )

    return cache(rendered)
