"""`catch-arena ros bag` and `ros import`: matches as recordings of rosbag2, and such recordings as films."""

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Literal

import typer

from catch_arena.cli.outputs import Force, output_file
from catch_arena.cli.ros import Package, Turtlesim, interfaces_of, ros
from catch_arena.cli.terminal import say
from catch_arena.cli.videos import Fps, Layout, VideoSize, print_report, width_and_height
from catch_arena.errors import BusError

_BAR_AFTER_S = 2.0


@ros.command()
def bag(
    replay: Annotated[Path, typer.Argument(metavar="REPLAY", help="A recorded match.")],
    *,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="DIR", help="The bag, a folder.", show_default="beside the replay, of its name"
        ),
    ] = None,
    storage: Annotated[Literal["mcap", "sqlite3"], typer.Option(help="The kind of its file.")] = "mcap",
    interfaces: Package = "my_robot_interfaces",
    turtlesim: Turtlesim = "turtlesim",
    force: Force = False,
) -> None:
    """Write a recorded match as a bag, for ros2 bag play and Foxglove (docs/ros2_bags.md)."""
    _require_rosbags()
    from catch_arena.cli.progress import progress_bar
    from catch_arena.replay import Replay
    from catch_arena.ros.bag_export import export_bag
    from catch_arena.ros.bag_files import require_free

    types = interfaces_of(interfaces, turtlesim)
    recorded = Replay.load(replay)
    folder = replay.with_suffix("") if output is None else output
    require_free(folder, force=force)
    with progress_bar("writing", after_s=_BAR_AFTER_S) as show:
        messages = export_bag(recorded, folder, storage, types, force=force, progress=show)
    say(f"bag: {folder} ({messages} messages)")


@ros.command(name="import")
def import_(
    bag: Annotated[Path, typer.Argument(metavar="BAG", help="A folder that ros2 bag record made, or its file.")],
    *,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="The film, which ends in .mp4, .webm, .gif or .webp.",
            show_default="an MP4 file beside the bag",
        ),
    ] = None,
    force: Force = False,
    listing: Annotated[bool, typer.Option("--list", help="Say what was ruled, and make no film.")] = False,
    reach: Annotated[float, typer.Option(metavar="M", help="The reach to judge by, in metres.")] = 0.3,
    size: VideoSize = None,
    fps: Fps = None,
    layout: Annotated[Layout, typer.Option(help="With the scores, or the arena alone.")] = "broadcast",
    speed: Annotated[float, typer.Option(help="Below 1 is slow motion, above 1 a time lapse.")] = 1.0,
) -> None:
    """Film a recording of turtlesim, and say of each catch in it what our arbiter would have ruled."""
    _require_rosbags()
    from catch_arena.cli.progress import progress_bar
    from catch_arena.ros.bag_import import read_recording
    from catch_arena.ros.recording_rulings import judge_recording, summary

    whole = bag.resolve()
    target = whole.with_suffix(".mp4") if output is None else output
    if not listing:
        from catch_arena.render.encoders import format_of, output_path

        format_of(target)
        output_file(output_path(target), force=force)
    with progress_bar("reading", after_s=_BAR_AFTER_S) as show:
        recording = read_recording(bag, show)
    judged = judge_recording(recording, reach)
    for one in judged:
        say(str(one))
    say(summary(judged))
    if recording.left_out:
        say(f"left out: {recording.left_out} messages that cannot be", err=True)
    if listing:
        return
    from catch_arena.ros.film import film_recording

    with progress_bar("rendering") as show:
        report = film_recording(
            recording,
            judged,
            target,
            reach_m=reach,
            title=whole.stem,
            size=None if size is None else width_and_height(size),
            fps=fps,
            layout=layout,
            speed=speed,
            progress=show,
        )
    print_report(report)


def _require_rosbags() -> None:
    if find_spec("rosbags") is None:
        raise BusError("bags need rosbags, which is not installed: pip install 'catch-arena[ros]'")
