"""Video of a bag, drawn as a match is."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil
from pathlib import Path

from catch_arena.config import TURTLESIM_SIDE_M
from catch_arena.core.physics import TICK_MS
from catch_arena.render import hud
from catch_arena.render.encoders import Progress, format_of
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.renderer import MatchRenderer
from catch_arena.render.timing import Clip
from catch_arena.render.video import RenderReport, frame_rate, frame_size, frames_of, pace_of, write_video
from catch_arena.replay.motion import Pose2D
from catch_arena.ros.bags.contents import BagContents
from catch_arena.ros.bags.rulings import JudgedCatch
from catch_arena.scenarios import scenario
from catch_arena.verdicts import Ruling
from catch_arena.world import HunterState, TargetState, World

_SILENT_MS = 500.0
"""A hunter without a pose for longer than this before the end is gone."""


def render_bag(
    bag: BagContents,
    judged: Sequence[JudgedCatch],
    path: Path,
    *,
    reach_m: float = 0.3,
    title: str = "",
    size: tuple[int, int] | None = None,
    fps: int | None = None,
    layout: hud.Layout = "broadcast",
    speed: float = 1.0,
    progress: Progress | None = None,
) -> RenderReport:
    """Write a bag as a video, with the arbiter's scores and words. The settings are those of `render_replay`.

    Args:
        bag: what was read from the bag.
        judged: its catches.
        path: a file that ends in .mp4, .webm, .gif or .webp.
        reach_m: the reach that is shown.
        title: the text above the standings.
        size: width and height in pixels.
        fps: frames per second.
        layout: "broadcast" or "arena".
        speed: seconds of the bag in a second of the video.
        progress: called with (frames written, frames in all).

    Raises:
        ConfigError: for a setting that is not allowed.
        OutputError: if the file cannot be written.
    """
    kind = format_of(path)
    within = frame_size(kind, size)
    ticks = ceil(bag.end_ms / TICK_MS)
    clip = Clip(0, ticks * TICK_MS, frame_rate(kind, fps), pace_of(speed))
    names = tuple(bag.hunters)
    config = scenario("standard", hunters=len(names), reach_m=reach_m)
    renderer = MatchRenderer(MatchInfo.of(config, names, title, clip.end_ms), within, layout)
    worlds = bag_worlds(bag, judged)
    frames = frames_of(worlds, renderer, clip)
    return write_video(path, frames, within, clip.fps, clip.frames, progress)


@dataclass(slots=True)
class _Life:
    """One target from its first list to its last."""

    name: str
    number: int
    begin_ms: float
    end_ms: float
    pose: Pose2D
    """Its last place in a list."""


def bag_worlds(bag: BagContents, judged: Sequence[JudgedCatch]) -> Iterator[World]:
    """Return the arena at each of turtlesim's ticks; a ruling is in the world of the tick after it."""
    coming = sorted(_lives(bag, judged), key=lambda life: life.begin_ms, reverse=True)
    alive: list[_Life] = []
    scores = [0] * len(bag.hunters)
    by_tick: dict[int, list[Ruling]] = {}
    for one in judged:
        by_tick.setdefault(int(one.request.time_ms // TICK_MS) + 1, []).append(one.ruling)
    for tick in range(ceil(bag.end_ms / TICK_MS) + 1):
        time_ms = tick * TICK_MS
        while coming and coming[-1].begin_ms <= time_ms:
            alive.append(coming.pop())
        alive = [life for life in alive if time_ms <= life.end_ms]
        rulings = tuple(by_tick.get(tick, ()))
        for ruling in rulings:
            scores[ruling.hunter] += ruling.success
        yield World(
            time_ms,
            tick,
            TURTLESIM_SIDE_M,
            tuple(_hunter(bag, name, seat, time_ms, scores[seat]) for seat, name in enumerate(bag.hunters)),
            tuple(_target(bag, life, time_ms) for life in sorted(alive, key=lambda life: life.number)),
            rulings,
        )


def _hunter(bag: BagContents, name: str, seat: int, time_ms: float, score: int) -> HunterState:
    track = bag.hunters[name]
    gone = time_ms > track.end_ms and bag.end_ms - track.end_ms > _SILENT_MS
    return HunterState(name, *track.at(time_ms), team=seat, score=score, withdrawn=gone)


def _target(bag: BagContents, life: _Life, time_ms: float) -> TargetState:
    track = bag.targets.get(life.name)
    x, y, theta = life.pose if track is None or time_ms < track.begin_ms else track.at(time_ms)[:3]
    return TargetState(life.name, life.number, x, y, theta, spawned_ms=int(life.begin_ms))


def _lives(bag: BagContents, judged: Sequence[JudgedCatch]) -> list[_Life]:
    """Return when each target was alive: by the lists, or by the poses in a bag without lists.

    A name that comes back is another target. A caught target is gone from then on, even if the next list comes later.
    """
    if not bag.lists:
        tracks = enumerate(bag.targets.items(), start=1)
        return [_Life(name, number, one.begin_ms, one.end_ms, one.poses[0][:3]) for number, (name, one) in tracks]
    lives: list[_Life] = []
    alive: dict[str, _Life] = {}
    for time_ms, turtles in bag.lists:
        named = {turtle.name: turtle for turtle in turtles if turtle.name}  # without a name it is not in turtlesim
        for name in alive.keys() - named.keys():
            alive.pop(name).end_ms = time_ms
        for name, turtle in named.items():
            if name not in alive:
                alive[name] = _Life(name, len(lives) + 1, time_ms, bag.end_ms + TICK_MS, turtle[1:])
                lives.append(alive[name])
            alive[name].pose = turtle[1:]
    for one in judged:
        if one.request.success:
            for life in lives:
                if life.name == one.request.name and life.begin_ms <= one.request.time_ms < life.end_ms:
                    life.end_ms = one.request.time_ms
    return lives
