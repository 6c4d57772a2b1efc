"""`catch-arena ros bag` and `ros import`: matches as bags of rosbag2, and bags as videos."""

import os
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Literal

import typer

from catch_arena.cli.bus import Packages
from catch_arena.cli.options import Recorded
from catch_arena.cli.outputs import VIDEO, VIDEO_HELP, Force, output_option, reserve_file
from catch_arena.cli.progress import progress_bar
from catch_arena.cli.ros import ros
from catch_arena.cli.terminal import echo
from catch_arena.cli.videos import Picture, write_video
from catch_arena.errors import BusError, ConfigError, install_hint


@ros.command()
def bag(
    replay: Recorded,
    *,
    output: Annotated[
        Path | None, output_option("Folder of the new bag.", "next to the replay, with its name", metavar="DIR")
    ] = None,
    storage: Annotated[Literal["mcap", "sqlite3"], typer.Option(help="File format in the bag.")] = "mcap",
    packages: Packages,
    force: Force = False,
) -> None:
    """Write a recorded match as a bag, for ros2 bag play and Foxglove (see `catch-arena docs ros2_bags`)."""
    _require_rosbags()
    from catch_arena.replay import Replay
    from catch_arena.ros.bags.export import export_bag

    recorded = Replay.load(replay)
    folder = output or replay.with_suffix("")
    if folder.suffix.lower() in {".mcap", ".db3", ".replay"}:
        raise ConfigError(f"{folder}: --output must be a folder, without the ending {folder.suffix}")
    with progress_bar("writing") as show:
        messages = export_bag(recorded, folder, storage, packages.types, force=force, progress=show)
    echo(f"bag: {folder} ({messages} messages)")


@ros.command(name="import")
def import_(
    bag: Annotated[Path, typer.Argument(metavar="BAG", help="Folder made by ros2 bag record, or the file in it.")],
    *,
    output: Annotated[Path | None, output_option(VIDEO_HELP, "an MP4 file next to the bag")] = None,
    force: Force = False,
    listing: Annotated[bool, typer.Option("--list", help="Print the rulings, and write no video.")] = False,
    reach: Annotated[float, typer.Option(metavar="M", help="Catch distance by which the arbiter judges [m].")] = 0.3,
    picture: Picture,
) -> None:
    """Make a video of a recording of turtlesim, and show how the arbiter would have judged each catch."""
    _require_rosbags()
    from catch_arena.ros.bags.reading import read_bag
    from catch_arena.ros.bags.rulings import judge_bag, summary

    whole = Path(os.path.realpath(bag))
    target = output or whole.with_suffix(".mp4")
    drawn = picture.arguments()
    if not listing:
        reserve_file(target, *VIDEO, force=force)
    with progress_bar("reading") as show:
        contents = read_bag(bag, show)
    judged = judge_bag(contents, reach)
    for one in judged:
        echo(str(one))
    echo(summary(judged))
    if contents.left_out:
        echo(f"left out: {contents.left_out} messages that are damaged or have impossible values", err=True)
    if listing:
        return
    from catch_arena.ros.bags.video import render_bag

    write_video(render_bag, contents, judged, target, reach_m=reach, title=whole.stem, **drawn)


def _require_rosbags() -> None:
    if find_spec("rosbags") is None:
        raise BusError(f"bags need rosbags, which is not installed: {install_hint('ros')}")
