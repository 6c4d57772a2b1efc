"""How fast frames are drawn and encoded on one core: `python scripts/bench_render.py [--seconds 20]`."""

import argparse
import os
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from catch_arena import Replay, parallel_env
from catch_arena.render.motion import passages
from catch_arena.render.raster import ArenaPainter, Stage
from catch_arena.render.scene import Look
from catch_arena.render.video import frame_count, mp4_file, render_replay


@dataclass(frozen=True)
class Args:
    """What is measured."""

    seconds: float
    """Of the match."""
    scenario: str
    width: int
    height: int
    fps: int


def parse() -> Args:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--scenario", default="standard")
    parser.add_argument("--width", type=int, default=1280)
    parser.add_argument("--height", type=int, default=720)
    parser.add_argument("--fps", type=int, default=60)
    return Args(**vars(parser.parse_args()))


def played(args: Args) -> Replay:
    """A match in which everybody chases the nearest target."""
    env = parallel_env(args.scenario, time_limit_s=args.seconds)
    env.record()
    _, infos = env.reset(seed=1)
    while env.agents:
        _, _, _, _, infos = env.step({agent: int(infos[agent]["action_mask"][1]) for agent in env.agents})
    return env.replay()


def line(what: str, frames: int, wall_s: float, cpu_s: float, fps: int) -> None:
    """One row of the table."""
    ratio = frames / wall_s / fps
    rates = f"{frames / wall_s:9.0f} frames/s {frames / cpu_s:9.0f} frames/CPU-s"
    print(f"{what:<28}{rates} {ratio:8.2f} x real time at {fps} fps")


def main() -> None:
    """Measure and print."""
    args = parse()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    cv2.setNumThreads(1)
    replay = played(args)
    worlds = list(replay.worlds())
    size = (args.width, args.height)
    print(
        f"{args.scenario}, {replay.config.hunters} hunters, {args.seconds:g} s, {args.width} x {args.height}, one core"
    )

    painter = ArenaPainter(replay.config)
    painter.paint(worlds[0])
    wall, cpu = time.perf_counter(), time.process_time()
    for world in worlds:
        painter.paint(world)
    rate = 1000.0 / replay.config.control_period_ms
    line("env.render(), 500 x 500", len(worlds), time.perf_counter() - wall, time.process_time() - cpu, round(rate))

    frames = frame_count(replay.steps * replay.config.control_period_ms, args.fps)
    stage = Stage(Look.of(replay.config), size, "broadcast")
    kept: list[np.ndarray] = []
    wall, cpu = time.perf_counter(), time.process_time()
    for passage in passages(worlds, args.fps, frames):
        stage.enter(passage.leg)
        for frame in passage.frames:
            time_ms = 1000.0 * frame / args.fps
            pixels = stage.draw(passage.leg, time_ms, passage.leg.at(time_ms, passage.next_tick))
            if frame < 120:
                kept.append(pixels.copy())
    line("paint", frames, time.perf_counter() - wall, time.process_time() - cpu, args.fps)

    with tempfile.TemporaryDirectory() as folder:
        wall, cpu = time.perf_counter(), time.process_time()
        with mp4_file(Path(folder, "encode.mp4"), size, args.fps, frames) as video:
            for frame in range(frames):
                video.write(kept[frame % len(kept)])
        line("encode, decode and count", frames, time.perf_counter() - wall, time.process_time() - cpu, args.fps)
        wall, cpu = time.perf_counter(), time.process_time()
        report = render_replay(replay, Path(folder, "match.mp4"), size=size, fps=args.fps)
        line("render_replay, all of it", frames, time.perf_counter() - wall, time.process_time() - cpu, args.fps)
        print(f"{report.bytes / 1e6 / report.seconds * 60:.1f} MB a minute, {report.codec}")


if __name__ == "__main__":
    main()
