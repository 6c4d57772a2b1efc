"""Draw the README's pictures: a moment, and ten seconds, of a match between four shipped agents."""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2

from catch_arena import Replay
from catch_arena.render.timing import Clip
from catch_arena.render.video import render_replay, rendered_frames, renderer_for

DOCS = Path(__file__).parent.parent / "docs"
AGENTS = ["patrol", "contested_by_time", "contested", "nearest"]
SEED = 6
MOMENT_S = 29.9
FROM_S, TO_S = 23.0, 33.0
MOST_BYTES = 2_000_000


def main() -> None:
    """Play the match, and render it."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    replay = recorded()
    picture, animation = DOCS / "picture.png", DOCS / "animation.gif"
    moment = Clip(round(1000 * MOMENT_S), round(1000 * MOMENT_S), fps=60)
    (pixels,) = rendered_frames(replay, renderer_for(replay, (1280, 720), "broadcast"), moment)
    cv2.imwrite(str(picture), cv2.cvtColor(pixels, cv2.COLOR_RGBA2BGR), [cv2.IMWRITE_PNG_COMPRESSION, 9])
    render_replay(replay, animation, start_s=FROM_S, end_s=TO_S)
    size = picture.stat().st_size + animation.stat().st_size
    print(f"{picture.name}, {animation.name}: {size / 1e6:.2f} MB together")
    if size > MOST_BYTES:
        raise SystemExit(f"the pictures must have at most {MOST_BYTES / 1e6:g} MB together; choose a shorter clip")


def recorded() -> Replay:
    """Return the replay of the match."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "match.replay")
        command = [Path(sys.executable).with_name("catch-arena"), "match", *AGENTS, "--seed", str(SEED), "-o", path]
        subprocess.run(command, check=True)
        replay = Replay.load(path)
    replay.title = "A match"
    return replay


if __name__ == "__main__":
    main()
