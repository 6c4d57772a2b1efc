"""A bag as a video, drawn as a match is."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from pathlib import Path

from catch_arena.config import TURTLESIM_SIDE_M
from catch_arena.core.physics import TICK_MS
from catch_arena.messages import Pose
from catch_arena.render import hud
from catch_arena.render.encoders import Progress, format_of
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.renderer import MatchRenderer
from catch_arena.render.timing import Clip
from catch_arena.render.video import RenderReport, frame_rate, frame_size, frames_of, pace_of, write_video
from catch_arena.ros.bags.contents import BagContents
from catch_arena.ros.bags.rulings import JudgedCatch
from catch_arena.scenarios import scenario
from catch_arena.world import HunterState, TargetState, World

_SILENT_MS = 500.0
"""A hunter that tells no pose for so long until the end has gone."""


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
    """Write a bag as a video; scores and words are the arbiter's.

    Args:
        bag: what was read of the bag.
        judged: its catches.
        path: which ends in .mp4, .webm, .gif or .webp.
        reach_m: the reach that is shown.
        title: what stands above the standings.
        size: as for `render_replay`, and so are the others.
        fps: frames a second.
        layout: "broadcast" or "arena".
        speed: seconds of the bag in a second of the video.
        progress: called with (frames written, frames in all).

    Raises:
        ConfigError: for a setting that cannot be.
        OutputError: where the file cannot be written.
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
    pose: Pose


def bag_worlds(bag: BagContents, judged: Sequence[JudgedCatch]) -> Iterator[World]:
    """The arena at each of turtlesim's ticks; the rulings stand in the world after the tick in which they fell."""
    lives = _lives(bag, judged)
    scores = dict.fromkeys(bag.hunters, 0)
    seats = {name: seat for seat, name in enumerate(bag.hunters)}
    by_tick: dict[int, list[JudgedCatch]] = {}
    for one in judged:
        by_tick.setdefault(int(one.asked.time_ms // TICK_MS) + 1, []).append(one)
    coming = sorted(lives, key=lambda life: life.begin_ms, reverse=True)
    alive: list[_Life] = []
    for tick in range(ceil(bag.end_ms / TICK_MS) + 1):
        time_ms = tick * TICK_MS
        while coming and coming[-1].begin_ms <= time_ms:
            alive.append(coming.pop())
        alive = [life for life in alive if time_ms <= life.end_ms]
        rulings = tuple(one.ruling for one in by_tick.get(tick, ()))
        for ruling in rulings:
            scores[tuple(seats)[ruling.hunter]] += ruling.success
        yield World(
            time_ms,
            tick,
            TURTLESIM_SIDE_M,
            tuple(_hunter(bag, name, seat, time_ms, scores) for name, seat in seats.items()),
            tuple(_target(bag, life, time_ms) for life in sorted(alive, key=lambda life: life.number)),
            rulings,
        )


def _hunter(bag: BagContents, name: str, seat: int, time_ms: float, scores: Mapping[str, int]) -> HunterState:
    track = bag.hunters[name]
    pose = track.at(time_ms)
    gone = time_ms > track.end_ms and bag.end_ms - track.end_ms > _SILENT_MS
    return HunterState(name, *pose, team=seat, score=scores[name], withdrawn=gone)


def _target(bag: BagContents, life: _Life, time_ms: float) -> TargetState:
    track = bag.targets.get(life.name)
    pose = life.pose if track is None or time_ms < track.begin_ms else track.at(time_ms)
    return TargetState(life.name, life.number, *pose[:3], spawned_ms=int(life.begin_ms))


def _lives(bag: BagContents, judged: Sequence[JudgedCatch]) -> list[_Life]:
    """Who was alive from when to when, by the lists; without lists, by the poses. A name that comes back is another
    target. Who is caught is gone, whenever the next list comes.
    """
    lives: list[_Life] = []
    if not bag.lists:
        for name, track in bag.targets.items():
            lives.append(_Life(name, len(lives) + 1, track.begin_ms, track.end_ms, track.placed[0].pose))
        return lives
    alive: dict[str, _Life] = {}
    for time_ms, (turtles,) in bag.lists:
        named = {turtle.name: turtle for turtle in turtles if turtle.name}  # without a name it never was anywhere
        for name in alive.keys() - named.keys():
            alive.pop(name).end_ms = time_ms
        for name, turtle in named.items():
            x, y = (min(max(number, 0.0), TURTLESIM_SIDE_M) for number in (turtle.x, turtle.y))
            pose = Pose(x, y, turtle.theta, 0.0, 0.0)
            if name not in alive:
                alive[name] = _Life(name, len(lives) + 1, time_ms, bag.end_ms + TICK_MS, pose)
                lives.append(alive[name])
            alive[name].pose = pose
    for one in judged:
        if one.asked.success:
            for life in lives:
                if life.name == one.asked.name and life.begin_ms <= one.asked.time_ms < life.end_ms:
                    life.end_ms = one.asked.time_ms
    return lives
