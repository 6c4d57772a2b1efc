"""`catch-arena verify`, `diff` and `explain`: checks, comparisons and explanations of recorded matches."""

import textwrap
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from catch_arena.cli.app import EXIT_ERROR, EXIT_NO, main
from catch_arena.cli.options import Recorded
from catch_arena.cli.terminal import WIDE, echo, own_console, progress_bar
from catch_arena.errors import ConfigError, ReplayError


@main.command()
def verify(replays: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Recorded matches.")]) -> None:
    """Play recorded matches again, and compare every step.

    If a match does not play as recorded, the first different step and the difference are printed, and the exit code is
    1. The exit code is 2 if a file cannot be read.
    """
    from catch_arena.replay import Replay, verification

    codes = []
    for path in replays:
        try:
            replay = Replay.load(path)
        except ReplayError as error:
            codes.append(EXIT_ERROR)
            echo(f"error: {error}", err=True)
            continue
        with progress_bar("verifying") as show:
            faults = verification.verify(replay, show)
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
    from catch_arena.replay import Replay
    from catch_arena.replay.comparison import replay_differences

    a, b = replays
    lines = replay_differences(Replay.load(a), Replay.load(b))
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
    from catch_arena.replay import Replay

    if at is not None and step is not None:
        raise ConfigError(f"--at must be left out with --step: got {at:g} and {step}")
    if what_if and at is None:
        raise ConfigError("--what-if needs --at, the time of a contest that was lost, as shown in the explanation")
    recorded = Replay.load(replay)
    if what_if and at is not None:
        contest = explanation.lost_contest_at(recorded, at, hunter)
        with progress_bar("searching") as show:
            answer = explanation.what_if(recorded, contest, hunter, show)
        _print_paragraphs([answer.sentence])
        return
    if at is not None:
        step = explanation.step_at(recorded, at)
    result: explanation.Explanation | explanation.StepExplanation
    if step is None:
        with progress_bar("playing") as show:
            result = explanation.explain(recorded, hunter, show)
    else:
        result = explanation.explain_step(recorded, step, hunter)
    _print_paragraphs(result.lines())


def _print_paragraphs(paragraphs: Iterable[str]) -> None:
    width = min(WIDE, own_console().width)
    for paragraph in paragraphs:
        echo(textwrap.fill(paragraph, width, subsequent_indent="    ", break_on_hyphens=False))
