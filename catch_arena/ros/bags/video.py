"""Video of a bag, drawn as a match is."""

from collections import deque
from collections.abc import Iterator, Sequence
from itertools import count
from math import ceil
from pathlib import Path

from catch_arena.config import TURTLESIM_SIDE_M
from catch_arena.core.physics import TICK_MS
from catch_arena.messages import Turtle
from catch_arena.render import hud
from catch_arena.render.captions import Captions
from catch_arena.render.encoders import Progress
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.renderer import MatchRenderer
from catch_arena.render.timing import Clip
from catch_arena.render.video import RenderReport, VideoOutput, frames_of
from catch_arena.ros.bags.reading import BagContents
from catch_arena.ros.bags.rulings import JudgedCatch
from catch_arena.scenarios import scenario
from catch_arena.world import HunterState, TargetState, World


def render_bag(
    bag: BagContents,
    judged: Sequence[JudgedCatch],
    path: Path,
    *,
    reach_m: float = 0.3,
    title: str = "",
    size: tuple[int, int] | None = None,
    shape: hud.FrameShape | None = None,
    fps: int | None = None,
    captions: Captions = "plain",
    progress: Progress | None = None,
) -> RenderReport:
    """Write a bag as a video, with the arbiter's scores and words. The settings are those of `render_replay`."""
    output = VideoOutput.of(path, size, shape, fps)
    ticks = ceil(bag.end_ms / TICK_MS)
    clip = Clip(0, ticks * TICK_MS, output.fps)
    names = tuple(bag.hunters)
    config = scenario("standard", hunters=len(names), reach_m=reach_m)
    info = MatchInfo.of(config, names, title, clip.end_ms)
    renderer = MatchRenderer(info, output.size, "broadcast", captions=captions)
    frames = frames_of(bag_worlds(bag, judged), renderer, clip.times_ms)
    return output.write(frames, clip.frames, progress)


def bag_worlds(bag: BagContents, judged: Sequence[JudgedCatch]) -> Iterator[World]:
    """Yield the arena at each of turtlesim's ticks; a list or a ruling counts from the tick after it.

    A name that comes back is another target.
    """
    lists, numbers = deque(bag.lists), count(1)
    listed: dict[str, Turtle] = {}
    born: dict[str, tuple[int, int]] = {}
    """Number and time of each target in the list."""
    scores = [0] * len(bag.hunters)
    by_tick: dict[int, list[JudgedCatch]] = {}
    for one in judged:
        by_tick.setdefault(int(one.time_ms // TICK_MS) + 1, []).append(one)
    for tick in range(ceil(bag.end_ms / TICK_MS) + 1):
        time_ms = tick * TICK_MS
        while lists and lists[0][0] < time_ms:
            listed_ms, turtles = lists.popleft()
            listed = {turtle.name: turtle for turtle in turtles if turtle.name}  # without a name: not in turtlesim
            born = {name: born.get(name) or (next(numbers), int(listed_ms)) for name in listed}
        catches = by_tick.get(tick, [])
        for one in catches:
            scores[one.ruling.hunter] += one.ruling.success
        yield World(
            time_ms,
            tick,
            TURTLESIM_SIDE_M,
            tuple(
                HunterState(name, *track.at(time_ms), team=seat, score=scores[seat])
                for seat, (name, track) in enumerate(bag.hunters.items())
            ),
            tuple(_target(one, *born[name]) for name, one in listed.items()),
            tuple(one.ruling for one in catches),
        )


def _target(listed: Turtle, number: int, spawned_ms: int) -> TargetState:
    return TargetState(listed.name, number, listed.x, listed.y, listed.theta, spawned_ms=spawned_ms)
