"""`catch-arena render`, `mosaic` and `highlights`: recorded matches become videos."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

import typer

from catch_arena.cli.app import Recorded, main
from catch_arena.cli.outputs import VIDEO, Force, given_or_free, output_file, require_ending
from catch_arena.cli.terminal import say
from catch_arena.errors import ConfigError, ReplayError

if TYPE_CHECKING:
    from catch_arena.explanation.highlights import Highlight, MatchEvents
    from catch_arena.render.video import RenderReport

_MOST_IN_ONE = 64

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="A folder with replays.")]
_VIDEO: Final = "The file to write, which ends in .mp4, .webm, .gif or .webp."
Video = Annotated[Path, typer.Option("--output", "-o", help=_VIDEO)]
VideoBeside = Annotated[
    Path | None, typer.Option("--output", "-o", help=_VIDEO, show_default="an MP4 file beside the replay")
]
LayoutOption = Annotated[
    Literal["broadcast", "arena"], typer.Option("--layout", help="With the scores, or the arena alone.")
]
Speed = Annotated[float, typer.Option(help="Below 1 is slow motion, above 1 a time lapse.")]
VideoSize = Annotated[
    str | None,
    typer.Option(
        metavar="WIDTHxHEIGHT", help="Size of the picture, in pixels.", show_default="1280x720; GIF, WebP 640x360"
    ),
]
Fps = Annotated[int | None, typer.Option(help="Frames per second.", show_default="60; GIF 25, WebP 30")]
ViewOf = Annotated[
    str | None,
    typer.Option(
        "--view-of", metavar="HUNTER", help="Show what this hunter sees, by its seat or name.", show_default="nobody's"
    ),
]


@main.command()
def render(
    replay: Recorded,
    *,
    output: VideoBeside = None,
    force: Force = False,
    size: VideoSize = None,
    fps: Fps = None,
    layout: LayoutOption = "broadcast",
    start: Annotated[float, typer.Option("--from", metavar="SECONDS", help="Where to begin in the match.")] = 0.0,
    end: Annotated[
        float | None, typer.Option("--to", metavar="SECONDS", help="Where to end.", show_default="the match's end")
    ] = None,
    speed: Speed = 1.0,
    view_of: ViewOf = None,
) -> None:
    """Turn a recorded match, or a part of it, into a video."""
    from catch_arena.cli.progress import progress_bar
    from catch_arena.render.video import render_replay
    from catch_arena.replay import Replay

    recorded = Replay.load(replay)
    target = replay.with_suffix(".mp4") if output is None else output
    output_file(target, *VIDEO, force=force)
    with progress_bar("rendering") as show:
        report = render_replay(
            recorded,
            target,
            size=None if size is None else width_and_height(size),
            fps=fps,
            layout=layout,
            start_s=start,
            end_s=end,
            speed=speed,
            view_of=view_of,
            progress=show,
        )
    print_report(report)


@main.command()
def mosaic(
    folder: Folder,
    *,
    output: Video,
    force: Force = False,
    size: Annotated[
        str | None,
        typer.Option(
            metavar="WIDTHxHEIGHT",
            help="Size of the picture, in pixels.",
            show_default="as the cells need, up to 1280x1280",
        ),
    ] = None,
    fps: Annotated[int | None, typer.Option(help="Frames per second.", show_default="30; GIF 25")] = None,
    speed: Speed = 1.0,
    count: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            max=_MOST_IN_ONE,
            help="At most this many matches, the first by name.",
            show_default=f"{_MOST_IN_ONE}",
        ),
    ] = None,
    view_of: ViewOf = None,
) -> None:
    """Show all matches of a folder at once, in a grid."""
    from catch_arena.cli.progress import progress_bar
    from catch_arena.render.mosaic import render_mosaic
    from catch_arena.replay import Replay

    frame_size = None if size is None else width_and_height(size)
    require_ending(output, *VIDEO)
    paths = _replays_in(folder)
    found: dict[str, Replay] = {}
    for path in paths:
        if len(found) == (count or _MOST_IN_ONE):
            break
        try:
            found[path.stem] = Replay.load(path)
        except ReplayError as error:
            _print_skipped(error)
    _require_some(folder, len(found), len(paths))
    output_file(output, *VIDEO, force=force)
    with progress_bar("rendering") as show:
        report = render_mosaic(found, output, size=frame_size, fps=fps, speed=speed, view_of=view_of, progress=show)
    say(f"matches: {len(found)} of {len(paths)}{_fewer(len(found), count, 'the folder has no more')}")
    print_report(report)


@main.command()
def highlights(
    folder: Folder,
    *,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help=_VIDEO, show_default="highlights.mp4, or the first free like it"),
    ] = None,
    force: Force = False,
    count: Annotated[int, typer.Option(metavar="N", min=1, help="At most this many moments.")] = 8,
    listing: Annotated[
        bool, typer.Option("--list", help="List the moments, the best last, and write nothing.")
    ] = False,
    size: VideoSize = None,
    fps: Fps = None,
    view_of: ViewOf = None,
) -> None:
    """Find the moments of a folder's matches that are worth seeing, and make a video of them.

    Close contests, catches of prey, changes of lead, streaks, close finishes, and upsets; the best comes last.
    """
    from catch_arena.cli.progress import progress_bar
    from catch_arena.explanation.formatting import seconds
    from catch_arena.explanation.highlights import select_highlights
    from catch_arena.render.highlight_video import render_highlights

    frame_size = None if size is None else width_and_height(size)
    if output is not None:
        require_ending(output, *VIDEO)
        if not listing:
            output_file(output, *VIDEO, force=force)
    found = _highlights_in(folder)
    selected = select_highlights({str(path): highlights for path, highlights in found.items()}, count)
    if not selected:
        raise ReplayError(f"{folder}: nothing worth seeing in {len(found)} matches: no contest, no change of lead, ...")
    for path, highlight in selected:
        say(f"{Path(path).name}  {seconds(highlight.decisive_ms)}  {highlight.kind}: {highlight.what}. {highlight.why}")
    if fewer := _fewer(len(selected), count, "there are no more that do not overlap"):
        say(f"moments: {len(selected)}{fewer}", err=True)
    if listing:
        return
    target = given_or_free(output, "highlights.mp4", force=force)
    with progress_bar("rendering") as show:
        report = render_highlights(selected, target, size=frame_size, fps=fps, view_of=view_of, progress=show)
    print_report(report)


def _fewer(got: int, asked: int | None, why: str) -> str:
    """What is said where there is less than was asked for."""
    return f", not {asked}: {why}" if asked is not None and got < asked else ""


def _highlights_in(folder: Path) -> "Mapping[Path, Sequence[Highlight]]":
    """What is worth seeing in a folder's matches; those that cannot be played are named and left out."""
    from catch_arena.cli.progress import progress_bar
    from catch_arena.explanation.highlights import find_highlights, win_rates, win_records

    paths = _replays_in(folder)
    matches = {}
    with progress_bar("looking", late=True) as show:
        for done, path in enumerate(paths, start=1):
            try:
                matches[path] = _events_of(path)
            except ReplayError as error:
                _print_skipped(error)
            show(done, len(paths))
    _require_some(folder, len(matches), len(paths))
    known = win_records(matches.values())
    return {path: find_highlights(events, win_rates(known, events)) for path, events in matches.items()}


def _events_of(path: Path) -> "MatchEvents":
    from catch_arena.explanation.highlights import extract_events
    from catch_arena.replay import Replay

    replay = Replay.load(path)
    try:
        return extract_events(replay)
    except ReplayError as error:
        raise ReplayError(f"{path}: {error}") from None


def _replays_in(folder: Path) -> list[Path]:
    """The replays of a folder, by name.

    Raises:
        ReplayError: where there is none.
    """
    if not folder.is_dir():
        raise ReplayError(f"{folder}: is no folder")
    paths = sorted(folder.glob("*.replay"))
    if not paths:
        raise ReplayError(f"{folder}: holds no replays (files that end in .replay)")
    return paths


def _require_some(folder: Path, good: int, paths: int) -> None:
    if not good:
        raise ReplayError(f"{folder}: none of {paths} replays can be played")


def _print_skipped(error: ReplayError) -> None:
    say(f"left out: {error}", err=True)


def print_report(report: "RenderReport") -> None:
    """Where the video is."""
    say(f"video: {report.path} ({report.frames} frames, {report.seconds:g} s)")


def width_and_height(text: str) -> tuple[int, int]:
    """«1280x720» as two numbers.

    Raises:
        ConfigError: for words of another form.
    """
    width, cross, height = text.lower().partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise ConfigError(f"size must be WIDTHxHEIGHT as in 1280x720, got {text!r}")
    return int(width), int(height)
