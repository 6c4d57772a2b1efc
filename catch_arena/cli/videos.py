"""`catch-arena render`, `mosaic` and `highlights`: videos of recorded matches."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import typer

from catch_arena.cli.app import main
from catch_arena.cli.options import Recorded
from catch_arena.cli.outputs import VIDEO, Force, output_file, require_ending
from catch_arena.cli.terminal import say
from catch_arena.errors import ConfigError, ReplayError

if TYPE_CHECKING:
    from catch_arena.explanation.highlights import Highlight
    from catch_arena.render.video import RenderReport

_MOST_IN_ONE = 64

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="A folder with replays.")]
_VIDEO: Final = "The file to write, which ends in .mp4, .webm, .gif or .webp."
Speed = Annotated[float, typer.Option(help="Below 1 is slow motion, above 1 a time lapse.")]
ViewOf = Annotated[
    str | None,
    typer.Option(metavar="HUNTER", help="Show what this hunter sees, by its seat or name.", show_default="no view"),
]


@dataclass(frozen=True)
class Picture:
    """Options for the frames of a video."""

    size: Annotated[
        str | None,
        typer.Option(
            metavar="WIDTHxHEIGHT", help="Size of the picture, in pixels.", show_default="1280x720; GIF, WebP 640x360"
        ),
    ] = None
    fps: Annotated[int | None, typer.Option(help="Frames per second.", show_default="60; GIF 25, WebP 30")] = None

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of functions that draw.

        Raises:
            ConfigError: for a size of another form.
        """
        return {"size": width_and_height(self.size), "fps": self.fps}


@dataclass(frozen=True)
class Film(Picture):
    """Options for the frames of one match's video."""

    layout: Annotated[Literal["broadcast", "arena"], typer.Option(help="With the scores, or the arena alone.")] = (
        "broadcast"
    )
    speed: Speed = 1.0

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of functions that draw.

        Raises:
            ConfigError: for a size of another form.
        """
        return {**super().arguments(), "layout": self.layout, "speed": self.speed}


@main.command()
def render(
    replay: Recorded,
    *,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help=_VIDEO, show_default="an MP4 file beside the replay")
    ] = None,
    force: Force = False,
    film: Film,
    start: Annotated[float, typer.Option("--from", metavar="SECONDS", help="Where to begin in the match.")] = 0.0,
    end: Annotated[
        float | None, typer.Option("--to", metavar="SECONDS", help="Where to end.", show_default="the match's end")
    ] = None,
    view_of: ViewOf = None,
) -> None:
    """Turn a recorded match, or a part of it, into a video."""
    from catch_arena.cli.progress import progress_bar
    from catch_arena.render.video import render_replay
    from catch_arena.replay import Replay

    recorded, drawn = Replay.load(replay), film.arguments()
    target = output or replay.with_suffix(".mp4")
    output_file(target, *VIDEO, force=force)
    with progress_bar("rendering") as show:
        report = render_replay(recorded, target, start_s=start, end_s=end, view_of=view_of, progress=show, **drawn)
    print_report(report)


@main.command()
def mosaic(
    folder: Folder,
    *,
    output: Annotated[Path, typer.Option("--output", "-o", help=_VIDEO)],
    force: Force = False,
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
    """Show all matches of a folder at the same time, in a grid."""
    from catch_arena.cli.progress import progress_bar
    from catch_arena.render.mosaic import render_mosaic
    from catch_arena.replay import Replay

    require_ending(output, *VIDEO)
    paths = _replays_in(folder)
    found: dict[str, Replay] = {}
    for path in paths:
        if len(found) == (count or _MOST_IN_ONE):
            break
        try:
            found[path.stem] = Replay.load(path)
        except ReplayError as error:
            say(f"left out: {error}", err=True)
    _require_some(folder, len(found), len(paths))
    output_file(output, *VIDEO, force=force)
    with progress_bar("rendering") as show:
        report = render_mosaic(found, output, speed=speed, view_of=view_of, progress=show)
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
    picture: Picture,
) -> None:
    """Find the moments of a folder's matches that are worth seeing, and make a video of them.

    Close contests, catches of prey, changes of lead, streaks, close finishes, and upsets; the best comes last.
    """
    from catch_arena.cli.progress import progress_bar
    from catch_arena.explanation.formatting import seconds
    from catch_arena.explanation.highlights import select_highlights
    from catch_arena.render.highlight_video import render_highlights

    drawn = picture.arguments()
    if output is not None:
        require_ending(output, *VIDEO)
        if not listing:
            output_file(output, *VIDEO, force=force)
    found = _highlights_in(folder)
    selected = select_highlights({str(path): highlights for path, highlights in found.items()}, count)
    if not selected:
        raise ReplayError(f"{folder}: nothing worth seeing in {len(found)} matches: no contest, no change of lead, ...")
    for path, highlight in selected:
        when = f"{Path(path).name}  {seconds(highlight.decisive_ms)}"
        say(f"{when}  {highlight.kind}: {highlight.event}. {highlight.reason}")
    if fewer := _fewer(len(selected), count, "there are no more that do not overlap"):
        say(f"moments: {len(selected)}{fewer}", err=True)
    if listing:
        return
    target = output or output_file(None, force=force, usual="highlights.mp4")
    with progress_bar("rendering") as show:
        report = render_highlights(selected, target, progress=show, **drawn)
    print_report(report)


def print_report(report: "RenderReport") -> None:
    """Print the path, the number of frames and the length of a video."""
    say(f"video: {report.path} ({report.frames} frames, {report.seconds:g} s)")


def width_and_height(text: str | None) -> tuple[int, int] | None:
    """Return the width and height in a text like «1280x720»; None for None.

    Raises:
        ConfigError: for a text of another form.
    """
    if text is None:
        return None
    width, cross, height = text.lower().partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise ConfigError(f"size must be WIDTHxHEIGHT as in 1280x720, got {text!r}")
    return int(width), int(height)


def _fewer(got: int, asked: int | None, why: str) -> str:
    """Return a note if there are fewer than requested; else an empty text."""
    return f", not {asked}: {why}" if asked is not None and got < asked else ""


def _highlights_in(folder: Path) -> "Mapping[Path, Sequence[Highlight]]":
    """Return the highlights of a folder's matches, by path; a replay that cannot be played is reported and left out."""
    from catch_arena.cli.progress import progress_bar
    from catch_arena.explanation.highlights import extract_events, find_highlights, win_rates, win_records
    from catch_arena.replay import Replay

    paths = _replays_in(folder)
    matches = {}
    with progress_bar("looking", late=True) as show:
        for done, path in enumerate(paths, start=1):
            try:
                matches[path] = extract_events(Replay.load(path))
            except ReplayError as error:
                named = "" if str(error).startswith(str(path)) else f"{path}: "
                say(f"left out: {named}{error}", err=True)
            show(done, len(paths))
    _require_some(folder, len(matches), len(paths))
    known = win_records(matches.values())
    return {path: find_highlights(events, win_rates(known, events)) for path, events in matches.items()}


def _replays_in(folder: Path) -> list[Path]:
    """Return the replays of a folder, by name.

    Raises:
        ReplayError: if there are none.
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
