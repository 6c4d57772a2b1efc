"""Turn a recorded match into an MP4 file: `python scripts/render.py REPLAY -o FILE.mp4 [--size 1280x720]`."""

import argparse
import sys
from dataclasses import dataclass

from rich.progress import Progress

from catch_arena import CatchArenaError, Replay
from catch_arena.render.video import RenderReport, render_replay


@dataclass(frozen=True)
class Args:
    """The command line."""

    replay: str
    output: str
    size: tuple[int, int]
    fps: int
    layout: str


def parse() -> Args:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("replay", help="the recorded match")
    parser.add_argument("-o", "--output", default="match.mp4", help="the file to write")
    parser.add_argument("--size", type=width_and_height, default=(1280, 720), metavar="WIDTHxHEIGHT")
    parser.add_argument("--fps", type=int, default=60)
    parser.add_argument("--layout", choices=("broadcast", "arena"), default="broadcast")
    return Args(**vars(parser.parse_args()))


def width_and_height(text: str) -> tuple[int, int]:
    """«1280x720» as two numbers."""
    width, cross, height = text.partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise argparse.ArgumentTypeError(f"size must be WIDTHxHEIGHT as in 1280x720, got {text!r}")
    return int(width), int(height)


def render(args: Args) -> RenderReport:
    """Write the video, with a progress bar."""
    with Progress(transient=True) as bar:
        task = bar.add_task("rendering", total=None)
        return render_replay(
            Replay.load(args.replay),
            args.output,
            size=args.size,
            fps=args.fps,
            layout=args.layout,
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )


def main() -> int:
    """The exit code: 0, or 2 with a line that says why not."""
    try:
        report = render(parse())
    except CatchArenaError as error:
        print(error, file=sys.stderr)
        return 2
    if report.notice:
        print(report.notice, file=sys.stderr)
    width, height = report.size
    print(
        f"{report.path}: {report.frames} frames, {report.seconds:g} s, {width} x {height}, in {report.elapsed_s:.1f} s"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
