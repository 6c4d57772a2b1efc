"""Play a tournament of six shipped agents and a final of the best four. out/demo gets a report, a video of the final,
and the best moments of all matches. Each step is a command of `catch-arena`, which is printed when it starts.
"""

from catch_arena import interrupts

if __name__ == "__main__":
    interrupts.listen()  # before the imports below

import argparse
import json
import os
import shlex
import subprocess
import sys
import time
from pathlib import Path
from typing import Final

import typer

FIELD: Final = ("patrol", "contested_by_time", "contested", "nearest", "first", "random")
"""Agents that play; a fixed list, so that new agents do not change the demo."""
SEED: Final = 7
PICTURE: Final = ("--size", "1024x576", "--fps", "30")


def has_desktop() -> bool:
    """Return whether the script runs in a terminal with a desktop, and not over SSH or in CI."""
    if not sys.stdout.isatty() or os.environ.get("CI"):
        return False
    if sys.platform in ("darwin", "win32"):
        return "SSH_CONNECTION" not in os.environ
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def run(*words: object) -> None:
    """Show a command and run it, in its own session, so that Ctrl-C reaches only this process.

    Raises:
        SystemExit: the command failed; the code is the command's.
    """
    line = [str(word) for word in words]
    print(f"\n$ catch-arena {shlex.join(line)}", flush=True)
    command = str(Path(sys.executable).with_name("catch-arena"))
    if code := subprocess.Popen([command, *line], start_new_session=True).wait():  # after Ctrl-C `interrupts` ends it
        sys.exit(code)


def demo(out: Path) -> dict[str, Path]:
    """Play the matches, and make the videos and the report; return the path of each result by its title."""
    replay, video, moments = out / "final.replay", out / "final.mp4", out / "moments.mp4"
    run("tournament", *FIELD, "--seed", SEED, "--record", "--out", out)
    best = [line["agent"] for line in json.loads((out / "standings.json").read_text())["standings"][:4]]
    run("match", *best, "--seed", SEED, "-o", replay)
    run("render", replay, *PICTURE, "-o", video)
    run("highlights", out / "replays", "--count", 3, *PICTURE, "-o", moments)
    return {"report": out / "report.html", "final": video, "best moments": moments}


def main() -> None:
    """Run the demo."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/demo"), help="new folder for the results")
    help_text = "open the results; the default if there is a desktop"
    parser.add_argument("--open", action=argparse.BooleanOptionalAction, default=has_desktop(), help=help_text)
    args = parser.parse_args()
    began = time.monotonic()
    made = demo(args.out)
    print(f"\nThe demo took {time.monotonic() - began:.0f} s. Results:")
    for name, path in made.items():
        print(f"  {name + ':':<14}{path}")
        if args.open:
            typer.launch(str(path))


if __name__ == "__main__":
    interrupts.run(main)
