"""How fast frames are drawn and encoded on one core, beside moviepy and plain pygame.

`python scripts/bench_render.py [--repeats 3] [--skip-long]`. Times are CPU seconds, those of child processes included:
the median of the repeats, after a first run that is not counted.
"""

import argparse
import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import av
import cv2
import numpy as np

from catch_arena import Replay, parallel_env
from catch_arena.render import scene, shapes
from catch_arena.render.annotations import Annotation, annotations_of, visible_annotations
from catch_arena.render.encoders import FORMATS, video_file
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.optional_imports import pygame
from catch_arena.render.raster import Pixels
from catch_arena.render.renderer import ArenaPainter
from catch_arena.render.timing import Clip, frame_spans
from catch_arena.render.video import clip_of, render_replay, rendered_frames, renderer_for
from catch_arena.render.viewport import OUTSIDE, Viewport
from catch_arena.replay.motion import Pose2D, step_motion


@dataclass(frozen=True)
class Args:
    """What is measured."""

    repeats: int
    skip_long: bool
    """Leave out 4K and the video of ten minutes."""
    memory: float | None
    """Only render a video of so many minutes, and say how much memory that took: what this script starts itself for."""


def parse() -> Args:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--skip-long", action="store_true")
    parser.add_argument("--memory", type=float, metavar="MINUTES")
    return Args(**vars(parser.parse_args()))


def played(scenario: str, seconds: float) -> Replay:
    """A match in which everybody chases the nearest target."""
    env = parallel_env(scenario, time_limit_s=seconds)
    env.record()
    _, infos = env.reset(seed=1)
    while env.agents:
        _, _, _, _, infos = env.step({agent: int(infos[agent]["action_mask"][1]) for agent in env.agents})
    return env.replay()


def cpu_s() -> float:
    """Of this process and of those that it waited for."""
    return sum(
        used.ru_utime + used.ru_stime
        for used in (resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN))
    )


def seconds_of(work: Callable[[], object], repeats: int) -> float:
    """The median of the repeats; the first run fills caches and is not counted."""
    work()
    times = []
    for _ in range(repeats):
        began = cpu_s()
        work()
        times.append(cpu_s() - began)
    return statistics.median(times)


def told(what: str, frames: int, seconds: float, more: str = "") -> None:
    """One row of the table."""
    print(f"{what:<52} {frames / seconds:7.0f} frames/s  {more}", flush=True)


def bench_env_render(scenario: str, args: Args) -> None:
    """`env.render()`, 500 x 500."""
    replay = played(scenario, 20.0)
    worlds = list(replay.worlds())
    painter = ArenaPainter(replay.config)
    seconds = seconds_of(lambda: [painter.paint(world) for world in worlds], args.repeats)
    told(f"env.render(), 500 x 500, {replay.config.hunters} hunters", len(worlds), seconds)


def bench_video(scenario: str, size: tuple[int, int], seconds: float, args: Args, ending: str = ".mp4") -> None:
    """All of it: playing, drawing, encoding."""
    replay = played(scenario, seconds)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"match{ending}")
        spent = seconds_of(lambda: render_replay(replay, path, size=size, fps=60), args.repeats)
        frames = round(60 * seconds)
        more = (
            f"{frames / spent / 60:5.2f} x real time at 60, {path.stat().st_size / seconds * 60 / 1e6:.1f} MB a minute"
        )
        told(f"{ending[1:]}, {size[0]} x {size[1]}, {replay.config.hunters} hunters", frames, spent, more)


def decoded(path: Path) -> list[Pixels]:
    """Every frame of a file, a quarter as wide and high."""
    with av.open(str(path)) as container:
        return [small(frame.to_ndarray(format="rgb24")) for frame in container.decode(video=0)]


def small(frame: Pixels) -> Pixels:
    """A quarter as wide and high."""
    return np.asarray(cv2.resize(frame, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def in_place(seen: list[Pixels], meant: list[Pixels]) -> int:
    """How many frames are there: nearer to the one that was drawn for their place than to those about it."""
    good = 0
    for place, frame in enumerate(seen[: len(meant)]):
        near = range(max(0, place - 2), min(len(meant), place + 3))
        distances = {other: float(np.abs(frame.astype(int) - meant[other]).mean()) for other in near}
        good += distances[place] <= min(distances.values()) + 1e-9
    return good


def bench_moviepy(args: Args) -> None:
    """Identical frames through our encoder and through moviepy, as Gymnasium's and PettingZoo's recorders do it."""
    from moviepy import ImageSequenceClip

    replay = played("standard", 3.0)
    renderer = renderer_for(replay, (1280, 720), "broadcast")
    clip = clip_of(replay, FORMATS[".mp4"], 60, 0.0, None, 1.0)
    frames = [cv2.cvtColor(pixels, cv2.COLOR_RGBA2RGB) for pixels in rendered_frames(replay, renderer, clip)]
    meant = [small(frame) for frame in frames]
    with tempfile.TemporaryDirectory() as folder:
        ours, theirs = Path(folder, "ours.mp4"), Path(folder, "theirs.mp4")

        def encode() -> None:
            with video_file(ours, (1280, 720), 60) as video:
                for frame in frames:
                    video.write(cv2.cvtColor(frame, cv2.COLOR_RGB2RGBA))

        def moviepy() -> None:
            ImageSequenceClip(frames, fps=60).write_videofile(str(theirs), logger=None)

        our_s, their_s = seconds_of(encode, args.repeats), seconds_of(moviepy, args.repeats)
        for what, path, spent in (("encoding alone", ours, our_s), ("moviepy, the same frames", theirs, their_s)):
            seen = decoded(path)
            more = f"{len(seen)} of {len(frames)} frames there, {in_place(seen, meant)} in their places"
            told(what, len(frames), spent, more)
        print(f"{'':<52} {their_s / our_s:7.1f} times moviepy's speed")


class PlainPygame:
    """The arena as one draws it with pygame alone: everything twice as large, then made smaller smoothly."""

    def __init__(self, info: MatchInfo, width: int, height: int) -> None:
        pygame.font.init()
        self.info = info
        self.viewport = Viewport(2 * width, 2 * height, info.config.side_m)
        self.size = (width, height)
        self.screen = pygame.Surface((2 * width, 2 * height), depth=32)
        self.ground = self.screen.copy()
        self.ground.fill(OUTSIDE)
        for shape in scene.ground_shapes(self.viewport):
            self.draw(self.ground, shape)
        self.clean = self.ground.copy()
        self.clean.set_alpha(12)
        self.fonts: dict[int, pygame.font.Font] = {}

    def frame(
        self, poses: tuple[Pose2D, ...], last: tuple[Pose2D, ...], described: list[shapes.Shape], fade: bool
    ) -> None:
        """Draw one frame."""
        if fade:
            self.ground.blit(self.clean, (0, 0))
        for seat, (start, end) in enumerate(zip(last, poses, strict=True)):
            self.draw(self.ground, scene.trail_shapes(self.viewport, self.info.color(seat), start, end)[0])
        self.screen.blit(self.ground, (0, 0))
        for shape in described:
            self.draw(self.screen, shape)
        pygame.transform.smoothscale(self.screen, self.size)

    def draw(self, on: "pygame.Surface", shape: shapes.Shape) -> None:
        """One shape by pygame's own means."""
        match shape:
            case shapes.Box():
                pygame.draw.rect(on, shape.color, (shape.left, shape.top, shape.width, shape.height))
            case shapes.Stroke():
                pygame.draw.line(
                    on, shape.color, (shape.x0, shape.y0), (shape.x1, shape.y1), max(1, round(shape.width))
                )
            case shapes.Polygon():
                pygame.draw.polygon(on, shape.color, shape.points)
            case shapes.Ring():
                side = math.ceil(2 * (shape.radius + shape.width)) + 2
                layer = pygame.Surface((side, side), pygame.SRCALPHA)
                middle = (side / 2, side / 2)
                pygame.draw.circle(layer, (*shape.color, round(255 * shape.veil)), middle, shape.radius)
                ring = (*shape.color, round(255 * shape.opacity))
                pygame.draw.circle(layer, ring, middle, shape.radius, max(1, round(shape.width)))
                on.blit(layer, (shape.x - side / 2, shape.y - side / 2))
            case shapes.Turtle():
                cosine, sine = math.cos(shape.theta), math.sin(shape.theta)
                turn = shape.length * np.array([[cosine, -sine], [-sine, -cosine]])
                for points, own, white in shapes.TURTLE_PARTS:
                    color = [min(255, round(own * part + 255 * white)) for part in shape.color]
                    pygame.draw.polygon(on, color, points @ turn.T + (shape.x, shape.y))
            case shapes.Label():
                font = self.fonts.setdefault(shape.size, pygame.font.Font(None, round(1.42 * shape.size)))
                text = font.render(shape.text, antialias=True, color=shape.color)
                on.blit(text, (shape.x - text.get_width() / 2, shape.y - text.get_height() / 2))


def bench_plain_pygame(args: Args) -> None:
    """The arena alone, 720 x 720, at 60 frames a second."""
    replay = played("standard", 10.0)
    worlds = list(replay.worlds())
    clip = Clip(0, 10_000, 60)
    renderer = renderer_for(replay, (720, 720), "arena")

    def ours() -> None:
        renderer.reset()
        for span in frame_spans(worlds, clip.times_ms):
            renderer.enter(span.motion)
            for time_ms in span.times_ms:
                renderer.draw(time_ms, span.motion.at(time_ms, span.next_tick))

    plain = PlainPygame(MatchInfo.of(replay.config), 720, 680)

    def theirs() -> None:
        annotations: list[Annotation] = []
        last = step_motion(worlds[0], worlds[0]).poses[0].hunters
        for span in frame_spans(worlds, clip.times_ms):
            now = span.motion
            annotations += annotations_of(now.before, now.after)
            for time_ms in span.times_ms:
                poses = now.at(time_ms, span.next_tick)
                described = scene.arena_shapes(
                    plain.viewport,
                    plain.info,
                    hunters=now.after.hunters,
                    poses=poses,
                    targets=[target for target in now.after.targets if target.spawned_ms <= time_ms],
                    annotations=visible_annotations(annotations, time_ms),
                    time_ms=time_ms,
                )
                plain.frame(poses.hunters, last, described, fade=int(time_ms) % 200 < 16)
                last = poses.hunters

    our_s, their_s = seconds_of(ours, args.repeats), seconds_of(theirs, args.repeats)
    told("the arena alone, 720 x 720", clip.frames, our_s)
    told("plain pygame, supersampled twice", clip.frames, their_s, f"ours is {their_s / our_s:.1f} times as fast")


def memory_of(minutes: float) -> None:
    """Render a video of so many minutes, and print the most memory that this took [MB]."""
    replay = played("standard", 60.0 * minutes)
    with tempfile.TemporaryDirectory() as folder:
        report = render_replay(replay, Path(folder, "match.mp4"), size=(640, 360), fps=60)
    print(report.frames, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024)


def bench_memory(minutes: tuple[float, ...]) -> None:
    """Peak memory of whole processes, which render 640 x 360 at 60 frames a second."""
    for length in minutes:
        command = [sys.executable, __file__, "--memory", str(length)]
        frames, most = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()[-2:]
        print(f"peak memory of {60 * length:g} s of video, {frames} frames: {most} MB", flush=True)


def main() -> None:
    """Measure and print."""
    args = parse()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    cv2.setNumThreads(1)
    if args.memory is not None:
        memory_of(args.memory)
        return
    # first, since a process's peak is at least what the one that started it had then
    bench_memory((1 / 6, 1.0 if args.skip_long else 10.0))
    for scenario in ("standard", "crowd"):
        bench_env_render(scenario, args)
    bench_plain_pygame(args)
    for scenario in ("standard", "crowd"):
        bench_video(scenario, (1280, 720), 10.0, args)
    bench_video("standard", (1280, 720), 10.0, args, ".webm")
    bench_moviepy(args)
    if not args.skip_long:
        for scenario in ("standard", "crowd"):
            bench_video(scenario, (3840, 2160), 5.0, args)


if __name__ == "__main__":
    main()
