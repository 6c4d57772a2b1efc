"""Commands about recorded matches: `catch-arena verify`, `diff` and `explain`, and videos by `render`, `clip`, `mosaic`
and `highlights`.
"""

import re
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, TypeVar

import typer

from catch_arena.cli.app import EXIT_ERROR, EXIT_NO, main
from catch_arena.cli.options import Recorded, listing_option
from catch_arena.cli.outputs import PAGE, VIDEO, VIDEO_HELP, Force, output_option, reserve_file, reserve_free_file
from catch_arena.cli.terminal import WIDE, echo, own_console, progress_bar
from catch_arena.errors import ConfigError, ReplayError
from catch_arena.files import write_whole
from catch_arena.text import printable
from catch_arena.tournament.store import STORE

if TYPE_CHECKING:
    from catch_arena.explanation import WhatIf
    from catch_arena.render.video import RenderReport
    from catch_arena.replay import Replay

_T = TypeVar("_T")

_MOMENTS: Final = 8
"""Number of moments that `highlights` finds by default."""

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder with replays.")]
Speed = Annotated[float, typer.Option(help="Playback speed: below 1 is slow motion, above 1 is a time lapse.")]


@dataclass(frozen=True)
class Picture:
    """Options for the frames of a video."""

    size: Annotated[
        str | None,
        typer.Option(
            metavar="WIDTHxHEIGHT", help="Size of the frames, in pixels.", show_default="1280x720; GIF, WebP 640x360"
        ),
    ] = None
    shape: Annotated[
        Literal["landscape", "portrait", "square"] | None,
        typer.Option(
            metavar="SHAPE",
            help="Shape of the frames: landscape, portrait or square.",
            show_default="landscape, or that of --size",
        ),
    ] = None
    fps: Annotated[int | None, typer.Option(help="Frames per second.", show_default="60; GIF 25, WebP 30")] = None
    captions: Annotated[
        Literal["plain", "clauses", "none"],
        typer.Option(metavar="KIND", help="plain captions, the same with clauses of the rulebook, or none."),
    ] = "plain"

    def arguments(self) -> dict[str, Any]:
        """Return these options as arguments of functions that draw."""
        if self.size is None:
            return vars(self)
        size = re.fullmatch(r"(\d+)x(\d+)", self.size.lower())
        if size is None:
            raise ConfigError(f"size must be WIDTHxHEIGHT, such as 1280x720, got {self.size!r}")
        return {**vars(self), "size": (int(size[1]), int(size[2]))}


@dataclass(frozen=True)
class Film(Picture):
    """Options for the video of a match, or of a part of it."""

    layout: Annotated[
        Literal["broadcast", "arena"],
        typer.Option(metavar="LAYOUT", help="broadcast shows the scores next to the arena, arena the arena alone."),
    ] = "broadcast"
    speed: Speed = 1.0
    start_s: Annotated[
        float | None,
        typer.Option("--from", metavar="SECONDS", help="Time in the match at which it begins.", show_default="0"),
    ] = None
    end_s: Annotated[
        float | None,
        typer.Option("--to", metavar="SECONDS", help="Time in the match at which it ends.", show_default="the end"),
    ] = None
    view_of: Annotated[
        str | None,
        typer.Option(metavar="HUNTER", help="Show the view of this hunter, a seat or a name.", show_default="none"),
    ] = None


@main.command()
def verify(replays: Annotated[list[Path], typer.Argument(metavar="FILE", help="Recorded matches.")]) -> None:
    """Play recorded matches again, and compare every step.

    If a match does not play as recorded, the first different step is printed, and the exit code is 1. The exit code is
    2 if a file cannot be read.
    """
    from catch_arena.replay.comparison import verify as play_and_compare

    codes = []
    for path in replays:
        try:
            replay = load_replay(path)
        except ReplayError as error:
            codes.append(EXIT_ERROR)
            echo(f"error: {error}", err=True)
            continue
        with progress_bar("verifying") as show:
            faults = play_and_compare(replay, show)
        for fault in faults:
            echo(f"{path}: {fault}", err=True)
        if faults:
            codes.append(EXIT_NO)
        else:
            echo(f"{path}: all {replay.steps} steps play as recorded")
    if codes:
        if len(replays) > 1:
            echo(f"{len(codes)} of {len(replays)} replays failed", err=True)
        raise typer.Exit(max(codes))


@main.command()
def diff(replays: Annotated[tuple[Path, Path], typer.Argument(metavar="A B", help="Two recorded matches.")]) -> None:
    """Show where two recorded matches differ: headers, actions, states, scores.

    The exit code is 0 if they are equal, 1 if they differ, 2 if one cannot be read.
    """
    from catch_arena.replay.comparison import replay_differences

    a, b = replays
    lines = replay_differences(load_replay(a), load_replay(b))
    if not lines:
        echo("the replays are equal")
        return
    for line in (f"A: {a}", f"B: {b}", *lines):
        echo(line)
    raise typer.Exit(EXIT_NO)


@main.command()
def explain(
    replay: Recorded,
    *,
    hunter: Annotated[
        str | None,
        typer.Option(
            metavar="HUNTER", help="Show only this hunter, team or prey: a seat from 0, a name, or prey_0, prey_1, ..."
        ),
    ] = None,
    at: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS", help="Explain the step that was judged at this time, as shown in the explanation."
        ),
    ] = None,
    step: Annotated[
        int | None,
        typer.Option(
            metavar="K", help="Explain step K, counted from 1: with steps of 0.1 s, step 124 begins at 12.3 s."
        ),
    ] = None,
    what_if: Annotated[
        bool,
        typer.Option(
            "--what-if",
            help="Find the smallest change of its actions with which the hunter that lost the contest at --at would "
            "have won it.",
        ),
    ] = False,
) -> None:
    """Explain the contests and refusals of a recorded match: the clause, the distances, the winner."""
    from catch_arena import explanation

    if at is not None and step is not None:
        raise ConfigError(f"--at must be left out with --step: got {at:g} and {step}")
    if what_if and at is None:
        raise ConfigError("--what-if needs --at, the time of a contest that was lost, as shown in the explanation")
    recorded = load_replay(replay)
    if at is not None:
        step = explanation.step_at(recorded, at)
    if at is not None and what_if:
        paragraphs = [_answer(recorded, at, hunter).sentence]
    elif step is not None:
        paragraphs = explanation.explain_step(recorded, step, hunter).lines()
    else:
        with progress_bar("playing") as show:
            paragraphs = explanation.explain(recorded, hunter, show).lines()
    width = min(WIDE, own_console().width)
    for paragraph in paragraphs:
        echo(textwrap.fill(paragraph, width, subsequent_indent="    ", break_on_hyphens=False))


@main.command()
def render(
    replay: Recorded,
    *,
    output: Annotated[
        Path | None,
        output_option(
            "File to write: a video, if its name ends in .mp4, .webm, .gif or .webp, or a page with a player, .html.",
            "an MP4 file next to the replay",
        ),
    ] = None,
    force: Force = False,
    film: Film,
    what_if: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            help="Show the contest that was lost at this time, and as a ghost what would have won it, as `catch-arena "
            "explain --at SECONDS --what-if` finds it.",
        ),
    ] = None,
    hunter: Annotated[
        str | None,
        typer.Option(metavar="HUNTER", help="The hunter that lost it, a seat or a name.", show_default="the nearest"),
    ] = None,
) -> None:
    """Turn a recorded match into a video, or into a page that plays it.

    A whole match has a title at its beginning and a podium at its end; a part, by --from, --to or --what-if, has
    neither.
    """
    recorded = load_replay(replay)
    usual = replay.with_suffix(".mp4")
    if what_if is not None:
        usual = replay.with_name(f"{replay.stem}-what-if-{what_if:g}s.mp4")
        if film.start_s is not None or film.end_s is not None:
            raise ConfigError(
                "--from and --to must be left out with --what-if, which shows the part around the contest"
            )
    elif hunter is not None:
        raise ConfigError("--hunter needs --what-if, the time of a contest that this hunter lost")
    target = output or usual
    paged = target.suffix.lower() == PAGE
    if paged and film != Film():
        raise ConfigError(f"{target}: options of a video must be left out for a page, whose player has controls")
    drawn = film.arguments()
    reserve_file(target, *VIDEO, PAGE, force=force)
    answer = None if what_if is None else _answer(recorded, what_if, hunter)
    if answer is not None:
        echo(answer.sentence)
    if not paged:
        _write_match(recorded, replay, target, what_if=answer, **drawn)
        return
    from catch_arena.player import player_page

    write_whole(target, player_page(recorded, answer).encode())
    echo(f"page: {target}")


@main.command()
def clip(
    replay: Recorded,
    *,
    at: Annotated[float, typer.Option(metavar="SECONDS", help="Time in the match that is in the middle of the clip.")],
    seconds: Annotated[float, typer.Option(metavar="SECONDS", help="Length of the clip.")] = 8.0,
    output: Annotated[Path | None, output_option(VIDEO_HELP, "an MP4 file next to the replay")] = None,
    force: Force = False,
) -> None:
    """Turn some seconds of a recorded match into a video; for one with other frames, use `render --from --to`."""
    recorded = load_replay(replay)
    whole_s = recorded.duration_ms / 1000.0
    if not 0.0 <= at <= whole_s:
        raise ConfigError(f"at must be a time in the match, from 0 to {whole_s:g} s, got {at:g}")
    if not seconds > 0.0:
        raise ConfigError(f"seconds must be positive, got {seconds:g}")
    start = min(max(0.0, at - seconds / 2.0), max(0.0, whole_s - seconds))
    target = output or replay.with_name(f"{replay.stem}-{at:g}s.mp4")
    reserve_file(target, *VIDEO, force=force)
    _write_match(recorded, replay, target, start_s=start, end_s=start + seconds)


def load_replay(path: Path) -> "Replay":
    """Return the replay in a file."""
    from catch_arena.replay import Replay

    return Replay.load(path)


def _answer(recorded: "Replay", at: float, hunter: str | None) -> "WhatIf":
    """Return what would have won the contest that a hunter lost at a time."""
    from catch_arena.explanation import lost_contest_at, what_if

    contest = lost_contest_at(recorded, at, hunter)
    with progress_bar("searching") as show:
        return what_if(recorded, contest, hunter, show)


def _write_match(recorded: "Replay", path: Path, target: Path, **options: Any) -> None:
    """Write a video of a recorded match, which was loaded from `path`, with options of `render_replay`.

    If a tournament's folder has the replay, the title names the tournament and the date.
    """
    from catch_arena.render.video import render_replay

    event, folder = "", path.absolute().parent
    if folder.name == "replays" and (folder.parent / STORE).exists():
        played = datetime.fromtimestamp(path.stat().st_mtime).astimezone()
        event = f"{printable(folder.parent.name)}, {played:%Y-%m-%d}"
    write_video(render_replay, recorded, target, event=event, **options)


@main.command()
def mosaic(
    folder: Folder,
    *,
    output: Annotated[Path, output_option(VIDEO_HELP)],
    force: Force = False,
    speed: Speed = 1.0,
    count: Annotated[
        int, typer.Option(metavar="N", min=1, max=64, help="Maximum number of matches; the first by name are shown.")
    ] = 64,
) -> None:
    """Show all matches of a folder at the same time, in a grid."""
    from catch_arena.render.mosaic import render_mosaic

    reserve_file(output, *VIDEO, force=force)
    matches, there = _from_replays(folder, lambda replay: replay, count)
    found = {Path(path).stem: replay for path, replay in matches.items()}
    echo(f"matches: {len(found)} of {there}")
    write_video(render_mosaic, found, output, speed=speed)


@main.command()
def highlights(
    folder: Folder,
    *,
    output: Annotated[Path | None, output_option(VIDEO_HELP, "highlights.mp4, or highlights-2.mp4 ...")] = None,
    force: Force = False,
    count: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Maximum number of moments.", show_default=str(_MOMENTS))
    ] = None,
    listing: Annotated[bool, listing_option("the moments, the best last")] = False,
    picture: Picture,
) -> None:
    """Find the moments of a folder's matches that are worth seeing, and make a video of them.

    Close contests, catches of prey, changes of lead, streaks, close finishes, and upsets; the best comes last.
    """
    from catch_arena.explanation import explain
    from catch_arena.explanation.formatting import seconds
    from catch_arena.explanation.highlights import best_highlights
    from catch_arena.render.highlight_video import render_highlights

    drawn = picture.arguments()
    if not listing:
        reserve_file(output, *VIDEO, force=force)
    matches, _ = _from_replays(folder, explain)
    selected = best_highlights(matches, count or _MOMENTS)
    if not selected:
        raise ReplayError(
            f"{folder}: no highlights in {len(matches)} matches: they have no contest, no change of lead, ..."
        )
    for path, highlight in selected:
        when = f"{Path(path).name}  {seconds(highlight.decisive_ms)}"
        echo(f"{when}  {highlight.kind}: {highlight.event}. {highlight.reason} ({highlight.clause})")
    if count is not None and len(selected) < count:
        echo(f"moments: {len(selected)}, not {count}: there are no more that do not overlap", err=True)
    if listing:
        return
    target = output or reserve_free_file("highlights.mp4", force=force)
    write_video(render_highlights, selected, target, **drawn)


def write_video(render: "Callable[..., RenderReport]", *arguments: Any, **options: Any) -> None:
    """Render a video with a progress bar, and print its path, its number of frames and its length."""
    with progress_bar("rendering") as show:
        report = render(*arguments, progress=show, **options)
    echo(f"video: {report.path} ({report.frames} frames, {report.seconds:g} s)")


def _from_replays(folder: Path, read: "Callable[[Replay], _T]", limit: int | None = None) -> tuple[dict[str, _T], int]:
    """Return what `read` makes of a folder's replays, by path, and the number of replays in the folder.

    A replay that cannot be played is reported and left out. At most `limit` are read, the first by name.
    """
    if not folder.is_dir():
        raise ReplayError(f"{folder}: is not a folder")
    paths = sorted(folder.glob("*.replay"))
    if not paths:
        raise ReplayError(f"{folder}: contains no replays (files that end in .replay)")
    found: dict[str, _T] = {}
    with progress_bar("reading") as show:
        for done, path in enumerate(paths, start=1):
            try:
                found[str(path)] = read(load_replay(path))
            except ReplayError as error:
                named = "" if str(error).startswith(str(path)) else f"{path}: "
                echo(f"left out: {named}{error}", err=True)
            if len(found) == limit:
                break
            show(done, len(paths))
    if not found:
        raise ReplayError(f"{folder}: none of {len(paths)} replays can be played")
    return found, len(paths)
